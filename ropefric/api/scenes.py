"""Scenes: what a hoist, a belt press, a band saw, a sheave or a belt drive does, and which effects that takes."""

from collections.abc import Callable

from ropefric.api.campaigns import PathLike
from ropefric.scenes.plan import Explanation, explain_scene
from ropefric.scenes.scene import Scene, load_scene
from ropefric.scenes.solve import Solution, solve_scene
from ropefric.scenes.sweep import Axis, Sweep, parse_axis, sweep_scene


def solve(scene: Scene | PathLike, *, level: float = 0.95) -> Solution:
    """Return the answer to a scene, simulated with the effects that its accuracy calls for.

    Parameters
    ----------
    scene : Scene or path-like
        The scene or its file.
    level : float
        Of the intervals.

    Returns
    -------
    Solution
        `to_dict()` holds the numbers, `warnings` what speaks against using them.

    Raises
    ------
    DataError
        With everything that is wrong with the file, or where the scene has no answer.

    Examples
    --------
    >>> import tempfile
    >>> from ropefric.scenes.scene_templates import write_scenes
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     hoist = solve(write_scenes(folder, ["hoist"])[0]).to_dict()
    >>> round(hoist["lift_force_N"]), hoist["effects"]["simulated"]
    (319, ['wrap-dependence', 'size', 'end-tension'])
    """
    return solve_scene(_as_scene(scene), level=level)


def explain(scene: Scene | PathLike, *, measure: bool = False) -> Explanation:
    """Return why a scene is solved the way it is: each effect, whether it is simulated, and what it is worth.

    Parameters
    ----------
    scene : Scene or path-like
        The scene or its file.
    measure : bool
        Solve with and without each effect, for its worth and its time.

    Examples
    --------
    >>> import tempfile
    >>> from ropefric.scenes.scene_templates import write_scenes
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     told = explain(write_scenes(folder, ["climbing-hoist"])[0])
    >>> told.plan.left_out
    ('centrifugal',)
    """
    return explain_scene(_as_scene(scene), measure=measure)


def sweep(
    scene: Scene | PathLike, *axes: str | Axis, progress: Callable[[int, int, str], None] | None = None
) -> Sweep:
    """Return the numbers of a scene's answer over a grid of any of its own numbers.

    Parameters
    ----------
    scene : Scene or path-like
        The scene or its file.
    *axes : str or Axis
        "wheel.wrap=90deg:1440deg:50", "wheel.radius=20mm,40mm"; several make a grid, of which the last runs fastest.
    progress : callable, optional
        Called with points done, points in all, and what they are.

    Returns
    -------
    Sweep
        `columns` by name, one value a point; `axes` and `shape` of the grid.

    Raises
    ------
    UnknownNameError
        For a key that the scene does not give, or that holds no number.
    InputError
        For values that the scene cannot take, or where no point has an answer.

    Examples
    --------
    >>> import tempfile
    >>> from ropefric.scenes.scene_templates import write_scenes
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     found = sweep(write_scenes(folder, ["hoist"])[0], "wheel.wrap=1turn,2turn,3turn")
    >>> found.columns["lift_force_N"].round().tolist()
    [205.0, 490.0, 1110.0]
    """
    loaded = _as_scene(scene)
    grid = tuple(parse_axis(loaded, axis) if isinstance(axis, str) else axis for axis in axes)
    return sweep_scene(loaded, grid, progress=progress)


def _as_scene(scene: Scene | PathLike) -> Scene:
    return scene if isinstance(scene, Scene) else load_scene(scene)
