"""A verb of the command line, whose error names every missing option at once."""

from typing import Any

from typer.core import TyperCommand

from gyrostat.verbs.required_options import missing_options, missing_text

_ALIASES = {"holdable": "feasible"}
"""Old name of a verb -> its name."""


class Verb(TyperCommand):
    """Command that reports all missing options in one message.

    Typer's own error names the first one only. Options that are needed because of other options are
    included; see `gyrostat.verbs.required_options`.
    """

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse the words of the command line; see `TyperCommand.parse_args`."""
        try:
            return super().parse_args(ctx, [*args])
        except Exception as error:
            if not _is_about_missing(error):
                raise
        values, *_ = self.make_parser(ctx).parse_args(args=[*args])
        missing = []
        for parameter in self.get_params(ctx):
            try:
                parameter.handle_parse_result(ctx, values, [])
            except Exception as error:
                if not _is_about_missing(error):
                    raise
                is_option = parameter.param_type_name == "option"
                missing.append(
                    max(parameter.opts, key=len) if is_option else parameter.name.upper()
                )
        verb = _ALIASES.get(self.name or "", self.name or "")
        missing += missing_options(verb, ctx.params)
        return ctx.fail(missing_text(self.name or "", missing))


def _is_about_missing(error: Exception) -> bool:
    """Whether an error is Typer's one about a missing option, which Typer does not export."""
    return type(error).__name__ == "MissingParameter"
