"""HTML pages from templates."""

from functools import lru_cache
from importlib.metadata import version

import jinja2

from gyrostat.core.text import plain
from gyrostat.core.units import RPM
from gyrostat.reports.page_policy import with_policy


@lru_cache
def _environment() -> jinja2.Environment:
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("gyrostat.reports"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"plain": plain, "rpm": lambda v: plain(v / RPM)}
    return environment


def render(template: str, **content: object) -> str:
    """Fill a template of this package, and state the content security policy of the page.

    Args:
        template: File name under templates/.
        content: Variables of the template.
    """
    page = _environment().get_template(template).render(version=version("gyrostat"), **content)
    return with_policy(page)
