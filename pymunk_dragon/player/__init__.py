"""A run as one self-contained page that plays it."""

from pymunk_dragon.player.page import PLAYER_ENDINGS, player_page, write_player

__all__ = ["PLAYER_ENDINGS", "player_page", "write_player"]
