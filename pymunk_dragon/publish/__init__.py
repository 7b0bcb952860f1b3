"""Pages at an address: lessons, scenes and anyone's program, with the engine in the browser.

Pyodide runs this package and Pymunk in a worker of the page; the server only has files.
"""
