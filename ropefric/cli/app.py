"""The program `ropefric`: finds the commands, runs one, and turns failures into words and exit codes."""

import importlib
import inspect
import os
import pkgutil
import sys
import traceback
from collections.abc import Callable, Sequence
from contextlib import nullcontext, redirect_stdout
from functools import cache
from itertools import takewhile
from typing import Annotated, Any

import typer

from ropefric import __version__
from ropefric.cli import commands, on_first_use
from ropefric.cli.options import Answer, Command
from ropefric.cli.output import Output, json_text
from ropefric.errors import InputError, InternalError, RopefricError, known_error
from ropefric.files.plain_text import visible
from ropefric.registry import Registry, did_you_mean

with on_first_use():
    from ropefric import plugins, section

USAGE, INTERRUPTED = 2, 130
EXIT_CODES = (
    "Exit codes: 0 done, 1 fault in ropefric, 2 wrong usage, 3 bad data or configuration, "
    "4 result that is not supported, 130 interrupted (129, 143: by SIGHUP, SIGTERM)."
)
_JSON = Annotated[bool, typer.Option("--json", help="Print the result as JSON, alone on stdout.")]
_QUIET = Annotated[bool, typer.Option("--quiet", "-q", help="No progress, notes or warnings.")]
_NO_COLOR = Annotated[bool, typer.Option("--no-color", help="Plain text; so does NO_COLOR=1.")]
_OWN = "A law, reader, outlier rule, protocol or machine of your own, a Python file; repeatable."
_PLUGIN = Annotated[list[str] | None, typer.Option("--plugin", metavar="FILE.py", help=_OWN)]
_GLOBAL_OPTIONS = {"json_": _JSON, "quiet": _QUIET, "no_color": _NO_COLOR}


@cache
def find_commands() -> Registry[Command]:
    """Return all commands by name, in the order of work: what the files of `commands` declare."""
    files = [found.name for found in pkgutil.iter_modules(commands.__path__)]
    modules = [importlib.import_module(f"{commands.__name__}.{name}") for name in files]
    declared = [one for module in modules for one in vars(module).values() if type(one) is Command]
    return Registry("command", sorted(declared, key=lambda command: command.order))


def main(argv: Sequence[str] | None = None, *, on_start: Callable[[], None] | None = None) -> int:
    """Run one command line and return its exit code; no exception leaves, and no plugin stays."""
    argv = sys.argv[1:] if argv is None else argv
    try:
        with plugins.unloaded_after():
            code = build_app(on_start)(args=list(argv), prog_name="ropefric", standalone_mode=False)
    except SystemExit as stop:  # typer's answer to a reader of --help that went away
        return 0 if isinstance(stop.__context__, BrokenPipeError) else int(stop.code or 0)
    except BaseException as error:  # noqa: BLE001  (the boundary: everything becomes words and a code)
        # The user's wishes, where typer did not get as far as reading them.
        words = set(takewhile(lambda word: word != "--", argv))
        wishes = {"json": "--json" in words, "quiet": bool(words & {"--quiet", "-q"})}
        return report_failure(error, Output(**wishes, color="--no-color" not in words))
    return code if isinstance(code, int) else 0


@cache
def build_app(on_start: Callable[[], None] | None = None) -> Any:
    """Return the program with every command of the registry, as typer calls it."""
    app = typer.Typer(
        name="ropefric",
        help="From force traces of a rope on a wheel to a friction law, and on to design.",
        epilog=EXIT_CODES,
        pretty_exceptions_enable=False,
        rich_markup_mode=None,  # rich takes twice as long to load as all else that a help needs
        context_settings={"help_option_names": ["--help", "-h"], "max_content_width": 110},
    )
    app.callback(invoke_without_command=True)(_top)
    for command in find_commands().values():
        text = inspect.getdoc(command.run) or ""
        said: Any = {"short_help": text.partition("\n\n")[0], "epilog": f"Example: {command.example}"}
        app.command(command.name, help=text, **said)(_with_global_options(command, on_start))
    return typer.main.get_command(app)


def _top(
    context: typer.Context,
    *,
    json_: _JSON = False,
    quiet: _QUIET = False,
    no_color: _NO_COLOR = False,
    plugin: _PLUGIN = None,
    version: Annotated[bool, typer.Option("--version", help="Print the version.")] = False,
) -> None:
    context.obj = Output(json=json_, quiet=quiet, color=not no_color)
    with redirect_stdout(sys.stderr) if json_ else nullcontext():
        for source in plugin or ():
            plugins.load_plugin(source)
    if version:
        text = json_text({"version": __version__}) if json_ else f"ropefric {__version__}"
        context.obj.result(f"{text}\n")
        raise typer.Exit
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())


def _with_global_options(command: Command, on_start: Callable[[], None] | None) -> Callable[..., int]:
    """Return the command as typer wants it: its own parameters and those that every command has."""

    def call(context: typer.Context, **arguments: Any) -> int:
        json_, quiet, no_color = (bool(arguments.pop(name)) for name in _GLOBAL_OPTIONS)
        sources = arguments.pop("plugin") or ()
        top: Output = context.obj
        out = Output(json=top.json or json_, quiet=top.quiet or quiet, color=top.color and not no_color)
        plugins.TOLD[:] = [out.note]
        try:
            if on_start is not None:
                on_start()
            # What a plugin prints is no part of the result.
            with redirect_stdout(sys.stderr) if out.json else nullcontext():
                for source in sources:
                    plugins.load_plugin(source)
                answer = command.run(out, **arguments)
            out.result(json_text(answer.data) + "\n" if out.json else _shown(answer))
        except KeyboardInterrupt as interrupt:  # typer would end here without a word
            return report_failure(interrupt, out)
        return answer.exit_code

    keyword = inspect.Parameter.KEYWORD_ONLY
    own = list(inspect.signature(command.run).parameters.values())[1:]
    parameters = [
        inspect.Parameter("context", inspect.Parameter.POSITIONAL_OR_KEYWORD, annotation=typer.Context),
        *(parameter.replace(kind=keyword) for parameter in own),
        *(inspect.Parameter(n, keyword, default=False, annotation=a) for n, a in _GLOBAL_OPTIONS.items()),
        inspect.Parameter("plugin", keyword, default=None, annotation=_PLUGIN),
    ]
    call.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    call.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    call.__name__ = command.name
    return call


def _shown(answer: Answer) -> str:
    """Return what people see of an answer."""
    return visible(f"{answer.show}\n" if isinstance(answer.show, str) else section.as_text(answer.show))


def report_failure(error: BaseException, out: Output) -> int:
    r"""Say what went wrong, as text on stderr or as the JSON error object on stdout, and return the exit code."""
    known, exit_code = _in_known_words(_interrupt_behind(error) or error)
    if out.json:
        out.result(json_text(known.to_dict()) + "\n")
    else:
        out.problems(known.problems)
    if exit_code == InternalError.exit_code and os.environ.get("ROPEFRIC_DEBUG", "") not in {"", "0"}:
        traceback.print_exception(error, file=sys.stderr)
    return exit_code


def _interrupt_behind(error: BaseException | None) -> KeyboardInterrupt | None:
    """Return the interrupt that a library has put into its own words, such as an import that was broken off."""
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__cause__ or error.__context__
    return error


def _in_known_words(error: BaseException) -> tuple[RopefricError, int]:
    if isinstance(error, KeyboardInterrupt):
        by = error.args[0] if error.args and isinstance(error.args[0], int) else INTERRUPTED - 128
        return RopefricError("interrupted", code="RF001"), 128 + by
    if hasattr(error, "format_message"):  # what typer raises for a command line that it cannot use
        return _usage_error(error), USAGE
    report_with = "the command you gave; ROPEFRIC_DEBUG=1 shows where it happened"
    known = known_error(error, report_with=report_with)
    return known, known.exit_code


def _usage_error(error: Any) -> InputError:
    """Return typer's complaint with the nearest thing that would have worked."""
    if isinstance(error.__cause__, InputError):  # an option's value, about which the library knows more
        return error.__cause__
    message = str(error.format_message()).strip()
    context = getattr(error, "ctx", None)
    option = getattr(error, "option_name", "")
    fix = f"see {context.command_path} --help" if context is not None else "see ropefric --help"
    if option and hasattr(error, "possibilities") and context is not None:
        known = [name for parameter in context.command.params for name in parameter.opts]
        message = str(error.message)
        fix = f"{did_you_mean(option, [*known, '--help'])} {fix}"
    elif ". Did you mean" in message:
        message, _, meant = message.partition(". D")
        fix = f"d{meant} {fix}"
    code = "RF120" if message.startswith("No such") else "RF110"
    return InputError(message[:1].lower() + message[1:], code=code, fix=fix)
