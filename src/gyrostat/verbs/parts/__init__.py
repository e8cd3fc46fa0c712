"""Parts that `export` can design and write, one file each or a few that belong together."""
