"""The program `ropefric`: assembles the commands and runs one."""

import inspect
import sys
from collections.abc import Callable, Sequence
from typing import Annotated, Any

import typer

from ropefric import __version__
from ropefric.cli.boundary import report_failure
from ropefric.cli.command import Answer, Command
from ropefric.cli.commands.catalogue import find_commands
from ropefric.cli.jsontext import json_text
from ropefric.cli.output import Output, rendered

_JSON = typer.Option("--json", help="Print the result as JSON, alone on stdout.", rich_help_panel="Output")
_QUIET = typer.Option("--quiet", "-q", help="No progress, notes or warnings.", rich_help_panel="Output")
_NO_COLOR = typer.Option("--no-color", help="Plain text; so does NO_COLOR=1.", rich_help_panel="Output")
_GLOBAL_OPTIONS = {"json_": _JSON, "quiet": _QUIET, "no_color": _NO_COLOR}

EXIT_CODES = (
    "Exit codes: 0 done, 1 fault in ropefric, 2 wrong usage, 3 bad data or configuration, "
    "4 result that does not stand, 130 interrupted (129, 143: by SIGHUP, SIGTERM)."
)


def main(argv: Sequence[str] | None = None, *, on_start: Callable[[], None] | None = None) -> int:
    """Run one command line and return its exit code; no exception leaves."""
    argv = sys.argv[1:] if argv is None else argv
    try:
        code = build_app(on_start)(args=list(argv), prog_name="ropefric", standalone_mode=False)
    except SystemExit as stop:  # typer's answer to a reader of --help that went away
        return 0 if isinstance(stop.__context__, BrokenPipeError) else int(stop.code or 0)
    except BaseException as error:  # noqa: BLE001  (the boundary: everything becomes words and a code)
        return report_failure(error, _wish(argv))
    return code if isinstance(code, int) else 0


def build_app(on_start: Callable[[], None] | None = None) -> typer.Typer:
    """Return the typer application with every command of the registry."""
    app = typer.Typer(
        name="ropefric",
        help="From force traces of a rope on a wheel to a friction law, and on to design.",
        epilog=EXIT_CODES,
        pretty_exceptions_enable=False,
        context_settings={"help_option_names": ["--help", "-h"]},
    )
    app.callback(invoke_without_command=True)(_top)
    for command in find_commands().values():
        app.command(command.name, help=inspect.getdoc(command.run), epilog=f"Example: {command.example}")(
            _with_global_options(command, on_start)
        )
    return app


def _top(
    context: typer.Context,
    *,
    json_: Annotated[bool, _JSON] = False,
    quiet: Annotated[bool, _QUIET] = False,
    no_color: Annotated[bool, _NO_COLOR] = False,
    version: Annotated[bool, typer.Option("--version", help="Print the version.")] = False,
) -> None:
    context.obj = Output(json=json_, quiet=quiet, color=not no_color)
    if version:
        text = json_text({"version": __version__}) if json_ else f"ropefric {__version__}"
        context.obj.result(f"{text}\n")
        raise typer.Exit
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())


def _with_global_options(command: Command, on_start: Callable[[], None] | None) -> Callable[..., int]:
    """Return the command as typer wants it: its own parameters and those that every command has."""

    def call(context: typer.Context, **arguments: Any) -> int:
        flags = {name: bool(arguments.pop(name)) for name in _GLOBAL_OPTIONS}
        top: Output = context.obj
        out = Output(
            json=top.json or flags["json_"],
            quiet=top.quiet or flags["quiet"],
            color=top.color and not flags["no_color"],
        )
        try:
            if on_start is not None:
                on_start()
            return _emit(command.answer(out, arguments), out)
        except KeyboardInterrupt as interrupt:  # typer would end here without a word
            return report_failure(interrupt, out)

    own = list(inspect.signature(command.run).parameters.values())[1:]
    common = [
        inspect.Parameter(
            name, inspect.Parameter.KEYWORD_ONLY, default=False, annotation=Annotated[bool, option]
        )
        for name, option in _GLOBAL_OPTIONS.items()
    ]
    context = inspect.Parameter("context", inspect.Parameter.POSITIONAL_OR_KEYWORD, annotation=typer.Context)
    parameters = [context, *(p.replace(kind=inspect.Parameter.KEYWORD_ONLY) for p in own), *common]
    call.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    call.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    call.__name__ = command.name
    return call


def _emit(answer: Answer, out: Output) -> int:
    out.result(json_text(answer.data) + "\n" if out.json else rendered(out.stdout, answer.show))
    return answer.exit_code


def _wish(argv: Sequence[str]) -> Output:
    """Return the user's output options where typer did not get as far as reading them."""
    words = list(argv)
    words = words[: words.index("--")] if "--" in words else words
    return Output(
        json="--json" in words, quiet="--quiet" in words or "-q" in words, color="--no-color" not in words
    )
