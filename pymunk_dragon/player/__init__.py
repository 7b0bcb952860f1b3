"""A run as one HTML file that plays it in any current browser, without network.

Play, step, scrub, zoom, follow the head, and switch on handles, velocities, contacts, the grid,
bench numbers and, for a run of the engine, the exact model. Point at a bench to read its speed, its
angle and the gap to the nearest other bench. Playing slows down near events. The key ? lists all
keys. The address (`run.html#t=409.8&follow=head`) leads to the same moment on another screen, and
`run.html?zh` opens the page in Chinese.

```console
$ pymunk-dragon simulate --from 405 -o run.npz
$ pymunk-dragon render run.npz -o run.html
```

![The player as the head passes bench 11, 0.9 mm away](renders/player.png)

Between two frames, page, films and `Run.poses_at` follow cubic polynomials with the positions and
velocities of both frames, and no number has more digits than the page's data. The whole run of the
reference scenario, 4,126 frames of 224 handles, is a page of 2.08 MB
(`python tests/bench/bench.py engine`).
"""

from pymunk_dragon.player.page import PLAYER_ENDINGS, player_page, write_player

__all__ = ["PLAYER_ENDINGS", "player_page", "write_player"]
