"""Verb `cache`: show and clear the compiled programs that are kept."""

from gyrostat.verbs.arguments import Say, silent


def cache(*, clear: bool = False, say: Say = silent) -> dict[str, object]:
    """Show the cache of compiled programs, or remove its entries.

    Args:
        clear: Whether to remove all entries; other files in the folder are kept.
        say: Function that receives each message for the user.

    Returns:
        "folder", "limit" (bytes), "size" (bytes), and "entries": engine that compiled them ->
        "count" and "size" (bytes). After clearing, "removed" is the number of removed entries.

    Raises:
        InputError: No private folder can be created, or an entry cannot be removed.
    """
    from gyrostat.core.cache import private_cache
    from gyrostat.core.cache_entries import KINDS, entries, limit
    from gyrostat.core.cache_entries import clear as remove_all
    from gyrostat.core.errors import InputError

    disk_cache = private_cache(say)
    if disk_cache is None:
        raise InputError("cache: found no private folder, expected one (see GYROSTAT_CACHE)")
    removed = len(remove_all(disk_cache.path)) if clear else None
    programs = entries(disk_cache.path)
    content: dict[str, dict[str, int]] = {}
    for kind in KINDS.values():
        sizes = [entry.size for entry in programs if entry.kind == kind]
        content[kind] = {"count": len(sizes), "size": sum(sizes)}
    size, largest = sum(entry.size for entry in programs), limit()
    say(f"folder {disk_cache.path}")
    if removed is not None:
        say(f"{removed} entries removed")
    for kind, row in content.items():
        say(f"  {kind}: {row['count']} programs, {row['size'] / 1e6:.1f} MB")
    say(f"  total {size / 1e6:.1f} MB of {largest / 1e6:.0f} MB (GYROSTAT_CACHE_LIMIT)")
    result: dict[str, object] = {
        "folder": str(disk_cache.path),
        "limit": largest,
        "size": size,
        "entries": content,
    }
    return result if removed is None else {**result, "removed": removed}
