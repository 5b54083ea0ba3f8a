"""Command lines that are refused: one sentence, status 2, and every folder stays as it was."""

import shlex
from pathlib import Path

import pytest
from commands import invoked

from pwmap.cli.app import app as pwmap_app
from pwmap.diagrams.record import keep_record
from woodpecker.cli.app import app

PROGRAMS = {"pwmap": pwmap_app, "woodpecker": app}
P1L = "Piecewise((r - 2, x <= 0), (r - a*x, True))"
OVER_R = f"pwmap analyse '{P1L}' --parameter r"
SKEW_PLANE = "pwmap plane 'Piecewise((a*x + 1, x <= 0), (b*x + 1, True))' --across a"
SPANS = "--across-span 1/4 3/4 --along-span -5 -1"
OF_MAPS = {
    f"pwmap analyse '{P1L}' --parameter b": "b is no parameter of this map, it has ['a', 'r']",
    f"pwmap analyse '{P1L}' --parameter ''": "'' is no parameter of this map, it has ['a', 'r']",
    f"pwmap analyse '{P1L}' --parameter b --set a=2": "b is no parameter of this map, it has ['a',",
    f"{OVER_R} --set 'a=sqrt(2)'":
        "--set a=sqrt(2): expected a rational number, such as 5/4: cannot read 'sqrt(2)'",
    f"{OVER_R} --set a": "--set needs name=value, such as a=5/4, got 'a'",
    f"{OVER_R} --set a=0.5,b=1": "value, and is repeated for others, got",
    f"{OVER_R} --set a=half": "--set a=half: expected a rational number",
    f"{OVER_R} --set r=1": "r is to vary, and cannot be set to 1 too",
    f"{OVER_R} --set a=1/2 --set a=0.25": "--set gives a two values, 1/2 and 1/4",
    f"{OVER_R} --given 'a > b'": "--given a > b: b is no parameter of this",
    f"{OVER_R} --set a=5/4 --sample a=1":
        "a sample is for parameters without a value, and r is the only one, got ['a']",
    "pwmap analyse 'r - 1.25*x' --parameter r": "write the rational 5/4 instead",
    f"{OVER_R} --set a=5/4 --orders '1;2'": "got '1;2'",
    f"{OVER_R} --set a=5/4 --orders 0": "got 0",
    f"{OVER_R} --set a=5/4 --span 2 1": "got (2, 1)",
    "pwmap analyse 'x**2 + r' --parameter r":
    "the piece x**2 + r is not affine in x; woodpecker.from_sympy takes maps with",
    "pwmap analyse 'x +' --parameter r": "cannot read 'x +' as an expression",
    "pwmap analyse 'r - x if x < 0' --parameter r": 'a map is typed as "Piecewise((r - 2, x <= 0)',
    "pwmap analyse 'r + sqrt(x)' --parameter r": "followed from Python, by woodpecker.from_sympy",
    "pwmap analyse 'Piecewise((r, x < 0))' --parameter r": "no piece covers x = 0",
    "pwmap plane x --pieces 0": "'--pieces': a whole number of at least 1 is expected, got ",
    "pwmap plane x --pieces 1.5": "a whole number of at least 1 is expected, got '1.5'",
    "pwmap plane x --raster 4 no": "'--raster': a whole number of at least 1 is expected, got",
    f"pwmap prove p*x --set p=1{5000 * '0'}": "an integer of 5001 digits is longer than 1000",
    "pwmap prove x --order two": "'--order': a whole number of at least 1 is expected, got ",
    "pwmap prove x --order 1 --order 2": "--order may be given only once",
    "pwmap analyse p*x --parameter p --span -2,2 --orders 1":
        "--span takes two values, such as --span -2 2, got '-2,2'",
    "pwmap plane p*x --across p --across-span 1 --along-span -4 -1": "values, such as --acr",
    "pwmap prove x --out=": "'--out': a path is expected, got ''",
    "pwmap prove x --out=c.csv": "expected a name in .json, got 'c.csv'",
    "pwmap analyse p*x --parameter p --span 0 1/0": "--span 0 1/0: cannot work out 0: it div",
    "pwmap analyse p*x --parameter p --span= 1":
        "--span '' 1: expected a rational number, such as 5/4: cannot read '' as an expression",
    "pwmap analyse p*x --parameter p --given=": "--given '': cannot read '' as an expression",
    "pwmap analyse p*x --parameter p --density nan": "--density nan: expected a rational number",
    "pwmap plane p*q*x --across p --along q --across-span 0 1 --along-span 2 1":
        "--along-span 2 1: a span must be an interval (low, high), got (2, 1)",
    "pwmap explore --port 65536": "a whole number of at least 1 and at most 65535 is expected",
    f"{OVER_R} --given 'a > 1' --sample a=1/2": "{'a': '1/2'} contradicts the assumption a > 1",
    f"{OVER_R} --set a=2 --entropy": "--attractors and --entropy need an interval of the parameter",
    f"{OVER_R} --attractors --span 0 1": "expected a map of r alone, this one has ['a', 'r']",
    f"{OVER_R} --density 1": "expected a map of r alone, this one has ['a', 'r']",
    f"{OVER_R} --set a=2 --density 'sqrt(2)'": "--density sqrt(2): expected a rational number",
    f"{OVER_R} --set a=2 --given 'r > 0' --density -1": "-1 contradicts the assumption r > 0",
    f"{SKEW_PLANE} --along b {SPANS} --given 'a > 1'": "a = 1/2 in the span contradicts the assump",
    f"{SKEW_PLANE} --along b {SPANS} --raster 4 3": "--raster needs --colours",
    f"{SKEW_PLANE} --along c {SPANS}": "c is no parameter of this map, it has ['a', 'b']",
    f"{SKEW_PLANE} --along b --set b=-2 {SPANS}": "b is to vary, and cannot be set to -2 too",
    # b >= a all over (-1, 5/2) needs a <= -1, and a*b < 1 there a >= -1
    "pwmap analyse 'Piecewise((a*x, x <= 0), (r - b*x, True))' --parameter b --given 'b >= a'"
    " --given 'a*b < 1' --span -1 5/2 --orders 1":
        "the assumptions leave only a = -1, where edges meet: give that value",
    f"pwmap prove '{P1L}' --set a=5/4":
        "r has no value: give it one, such as --set r=1, or certify",
    f"pwmap prove '{P1L}' --set a=2 --set r=1 --orders 1,2": "need a --parameter",
    f"pwmap prove '{P1L}' --set a=2 --set r=1 --span 0 1": "need a --parameter",
    f"pwmap prove '{P1L}' --set a=2 --parameter r --order 3": "a --parameter has --orders",
    f"pwmap prove '{P1L}' --parameter r": "must have the parameter r alone",
}  # fmt: skip
OF_THE_TOY = {
    "woodpecker diagram --span=0.5": "takes two values, such as --span -2 2, got '0.5'; see",
    "woodpecker diagram --format jpg": "'--format': 'jpg' is not one of 'png', 'pdf', 'svg'",
    "woodpecker robustness --format png": "'png' is not one of 'csv', 'json'",
    "woodpecker map --points 1": "'--points': a whole number of at least 2 is expected, got '1'",
    "woodpecker map --g 9 --points 2 --g=9.8": "--g may be given only once",
    f"woodpecker simulate --samples {5000 * '9'}": "at least 2 is expected, got '99999999999999999",
    "woodpecker diagram --parameter eps_n9": "unknown parameter 'eps_n9'",
    "woodpecker diagram --parameter eps-n1 --span 0.6 0.9": "must hold eps_n1 = 0.5",
    "woodpecker diagram --span 0.9 0.1": "span must ascend",
    "woodpecker diagram --window -1 -0.8": "window must hold the orbit, phi_S = -0.529472",
    "woodpecker diagram --names A":
        "--names needs name=parameter,phi_S or name=id for each, got 'A'",
    "woodpecker diagram --names A=1,x":
        "--names needs name=parameter,phi_S or name=id for each, got 'A=1,x'",
    "woodpecker diagram --names a=nan,-0.9": "name=parameter,phi_S or name=id for each, got 'a=n",
    "woodpecker animate --file ''": "an animation is a .gif or an .mp4, got ''",
    "woodpecker animate --file ..gif": "an animation is a .gif or an .mp4, got '..gif'",
    "woodpecker map --points 5 --window -0.5 -0.49999999999999994":
        "window has no 5 different numbers in it, got (-0.5, -0.49999999999999994)",
    "woodpecker prove --span 0.6 0.4": "span must ascend, got (0.6, 0.4)",
    "woodpecker prove --span 0.4 inf": "span must be finite, got (0.4, inf)",
    "woodpecker robustness --parameters ''": "unknown parameter '', expected one of",
    "woodpecker simulate --toy ' '": "'--toy': a path is expected, got ' '",
    "woodpecker curves --second-span 0.5 0.3": "span of mu_2 must ascend, got (0.5, 0.3)",
    "woodpecker curves --second-span 0.3 inf": "span of mu_2 must be finite, got (0.3, inf)",
    "woodpecker diagram --names 'a=PD1 b=PD1'": "one name for each point, got two for PD1",
    "woodpecker diagram --names 'a=PD1 a=PD2'": "one place for each name, got two for a",
    "woodpecker diagram --step 1e-20": "max_step must be at least min_step = 1e-13, got 1e-20",
    "woodpecker diagram --window -0.8 -1": "window must ascend",
    "woodpecker diagram --orders 1 --window -inf 0": "needs a finite window",
    "woodpecker diagram --resume": "there is no saved run",
    "woodpecker diagram --observables period,speed":
        "an observable must be one of period, drop, got 'speed'",
    "woodpecker map --window -0.2 -0.3": "window must ascend",
    "woodpecker map --window -0.2 0.3": "where the beak touches the pole",
    "woodpecker map --window -inf 0.1": "window must be finite, got (-inf, 0.1)",
    "woodpecker map --window nan 0.1": "window must ascend, got (nan, 0.1)",
    "woodpecker map --points 10000001": "got 1 times 10000001: ask for fewer",
    "woodpecker map --order 0": "--order",
    "woodpecker diagram --orders 1 --workers 1000": "one for each core, got 1000",
    "woodpecker diagram --orders 1 --workers 0": "--workers",
    "woodpecker diagram --also two": "--also needs integers such as 1,2,4 or 1-8, got 'two'",
    "woodpecker diagram --also 2 --orders 1": "take one of them",
    "woodpecker animate --size 0 4": "a width and a height of at most 40 inches, got 0.0 4.0",
    "woodpecker simulate --samples -5": "--samples",
    "woodpecker curves --parameters eps_n1": "--parameters needs two different names",
    "woodpecker curves --parameters eps_n1,mu": "unknown parameter 'mu'",
    "woodpecker curves --parameters eps-n1,eps_n1": "--parameters needs two different names",
    "woodpecker curves --parameters eps_n1,eps_n2": "--second-span is needed where eps_n2 is 0.0",
    "woodpecker curves --from Z --second-span 0.298 0.31": "--from must be among A",
    "woodpecker regions --parameters eps_n1": "two different names",
    "woodpecker regions --parameters eps_n1,pole": "--second-span is needed where pole is inf",
    "woodpecker curves --span 0.9 0.1": "span must ascend, got (0.9, 0.1)",
    "woodpecker diagram --span 2 3": "span must hold values of eps_n1 in (0.0, 1.0), got (2.",
    "woodpecker prove --phi-s 3": "phi_s must be finite and below 0.12, where the beak touches the",
    "woodpecker regions --second-span 0.3 0.2": "span of mu_2 must ascend, got (0.3, 0.2)",
    "woodpecker simulate --phi-s 3": "phi_s must be finite and below 0.12, where the beak touches",
    "woodpecker simulate --t-end -1": "t_end must be positive and finite, got -1.0",
    "woodpecker prove --span 0.4 0.5 --point A": "either a span or a point can be proved, not both",
    "woodpecker simulate --mass 1": "Error: No such option: --mass",
    "woodpecker simulate --mass=1": "simulate --help",
    "woodpecker simulate --g heavy": "'--g': a number such as 0.5 is expected, got 'heavy'; see ",
    "woodpecker diagram --span 0 x": "expected, got 'x'",
    "woodpecker simulate --out=": "Invalid value for '--out': a path is expected, got ''",
    "woodpecker map --toy .": "this is a folder, and a file is expected",
    "woodpecker simulate --format csv --format json":
        "--format takes one of csv and json, got csv and json",
    **{f"woodpecker {command} {option}": sentence
       for command in ("simulate", "map", "diagram")
       for option, sentence in (
           ("--m-s -1", "m_s must be positive and finite, got -1.0"),
           ("--eps-n1 1.5", "eps_n1 must lie in [0, 1], got 1.5"),
           ("--r-m 0.002", "r_m must exceed r_0 = 0.0025"),
           ("--mu-2 nan", "mu_2 must be at least 0 and finite, got nan"),
           ("--pole 0", "pole must be positive, got 0.0"),
           ("--expansion-friction both", "'both' is not one of 'summed', 'separate'"),
       )},
}  # fmt: skip
REFUSED = [
    *(pytest.param(*row, id=row[0][:80]) for row in OF_MAPS.items()),
    *(pytest.param(*row, id=row[0][:80], marks=pytest.mark.slow) for row in OF_THE_TOY.items()),
]


@pytest.mark.parametrize(("typed", "sentence"), REFUSED)
def test_a_refused_command_says_why_and_leaves_all_as_it_was(
    typed: str, sentence: str, tmp_path: Path
) -> None:
    """In a folder with results of an earlier run nothing is replaced, and no new one is made."""
    program, command, *arguments = shlex.split(typed)
    earlier = tmp_path / "earlier"
    earlier.mkdir()
    for name in (names := ["own.csv", "certificate.json"]):
        (earlier / name).write_text("kept")
    keep_record(earlier, command, names, {})
    before = [*tmp_path.rglob("*")]
    for out in (earlier, tmp_path / "new" / "out"):
        to = () if command == "explore" or "--out=" in typed else ("--out", str(out))
        found = invoked(PROGRAMS[program], command, *arguments, *to)
        assert found.exit_code == 2
        assert found.output.startswith("Error: ")
        assert sentence in found.output
        assert len(found.output.splitlines()) == 1
        assert [*tmp_path.rglob("*")] == before
    assert [(earlier / name).read_text() for name in names] == ["kept", "kept"]
