"""The code behind the lessons: reading and running them; terminal, page and notebook."""
