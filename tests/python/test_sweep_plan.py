"""The plan of a sweep and what is wrong with it; its table; what is told from it."""

import subprocess
import sys

import pytest
from conftest import LOG, MAP, ROOT, TRUTH
from sweep_here import SCENARIO

import parloc
from parloc import intervals
from parloc.sweeps import effects
from parloc.sweeps.plan import read_plan
from parloc.sweeps.table import Table

pytest.importorskip("yaml")


@pytest.fixture
def read(tmp_path):
    """read(text) is the plan in a file."""

    def of(text):
        path = tmp_path / "s.yaml"
        path.write_text(text)
        return read_plan(path)

    return of


ON = f"scenarios: {SCENARIO}\n"


def test_a_grid_has_all_combinations(read):
    plan = read(ON + "trials: 7\nsettings:\n  particles: [100, 200]\n"
                "  sensor.sigma_hit: {from: 0.1, to: 0.4, steps: 3, scale: log}\n  sensor.model: [beam]\n")
    assert [p["sensor.sigma_hit"] for p in plan.points] == [0.1, 0.2, 0.4] * 2
    assert [p["particles"] for p in plan.points] == [100] * 3 + [200] * 3
    assert plan.configs[4].sensor.model == "beam" and plan.configs[4].sensor.sigma_hit == 0.2
    assert plan.trials == 42 and len(plan.runs) == 6 and plan.runs[0].words[0] == "evaluate"


def test_points_are_drawn_alike_everywhere(read):
    text = ON + "settings:\n  particles: {from: 100, to: 10000, scale: log}\n  motion.alpha1: {from: 0, to: 1}\ndraw: 50\n"
    plan, again, other = read(text), read(text), read(text + "draw_seed: 2\n")
    assert plan.points == again.points != other.points and len(plan.points) == 50
    assert all(isinstance(p["particles"], int) and 100 <= p["particles"] <= 10000 for p in plan.points)
    assert sum(p["particles"] < 1000 for p in plan.points) in range(15, 36)
    assert plan.points[0] == {"particles": 186, "motion.alpha1": 0.847434}


def test_logs_and_filters_and_a_base(read, tmp_path):
    (tmp_path / "base.yaml").write_text("particles: 77\n")
    (tmp_path / "mine.yaml").write_text("motion:\n  alpha1: 0.3\n")
    log = f"{{log: {LOG}, map: {MAP}, truth: {TRUTH}}}"
    plan = read(f"scenarios: [{SCENARIO}]\nlogs: [{log}]\nfilters: [mcl, edh@100=mine.yaml]\ntrials: 2\nconfig: base.yaml\n"
                "kidnap: 3..5,2\n")
    assert plan.configs[0].particles == 77 and [run.words[0] for run in plan.runs] == ["compare", "compare"]
    words = plan.runs[1].words
    assert words[words.index("--filters") + 1] == f"mcl,edh@100={tmp_path / 'mine.yaml'}" and "--log" in words
    assert words[words.index("--kidnap") + 1] == "3..5,2" and words[words.index("--seeds") + 1] == "2"
    words = read(f"logs: {log[:-1]}, starts: 6}}\nseed: 3\n").runs[0].words
    assert words[words.index("--starts") + 1] == "6" and "--seed" not in words and "--trials" not in words


@pytest.mark.parametrize(("text", "error"), [
    (ON + "trails: 3\n", r"s.yaml:2: unknown key 'trails'; the nearest valid key is 'trials'"),
    (ON + "settings:\n  sensor.sigmahit: [1]\n",
     r"s.yaml:3: there is no setting 'sensor.sigmahit'; the nearest is 'sensor.sigma_hit'"),
    (ON + "settings:\n  sensor.sigma_hit:\n    - 0.2\n    - -1\n", r"s.yaml:5: sensor.sigma_hit must be 0.001 to 10, got -1"),
    (ON + "settings:\n  particles: [1.5]\n", r"s.yaml:3: particles must be 1 to 16777216"),
    (ON + "settings:\n  particles: []\n", r"s.yaml:3: particles: expected a list of values"),
    (ON + "settings:\n  particles: [5, 5]\n", r"s.yaml:3: particles: expected each value once"),
    (ON + "settings:\n  particles: {from: 5, to: 9}\n", r"s.yaml:3: particles: expected the key 'steps' as well"),
    (ON + "settings:\n  particles: {from: 5, to: 9, step: 2}\n",
     r"s.yaml:3: unknown key 'step'; the nearest valid key is 'steps'"),
    (ON + "settings:\n  particles: {from: 5, to: 4, steps: 2}\n",
     r"s.yaml:3: particles: expected more than from, 5, got 4"),
    (ON + "settings:\n  motion.alpha1: {from: 0, to: 1, steps: 2, scale: log}\n", r"expected more than 0, as the scale is log"),
    (ON + "settings:\n  motion.alpha1: {from: 0, to: 1, steps: 2, scale: cubic}\n",
     r"scale: expected linear or log, got cubic"),
    (ON + "settings:\n  motion.alpha1: {from: 0, to: 1, steps: 2}\ndraw: 3\n", r"s.yaml:3: motion.alpha1: steps make a grid"),
    (ON + "settings:\n  sensor.z_hit: [0.9]\n  sensor.z_rand: [0.9]\n",
     r"s.yaml:2: at sensor.z_hit=0.9, sensor.z_rand=0.9: .*z_hit"),
    (ON + "settings: 3\n", r"s.yaml:2: settings: expected a group of names"),
    (ON + "trials: 0\n", r"s.yaml:2: trials: expected a whole number from 1 to 10000000, got 0"),
    (ON + "trials: 3\ntrials: 4\n", r"s.yaml:3: the key 'trials' is there twice"),
    (ON + "draw: 3\n", r"s.yaml:2: draw: expected settings to draw"),
    (ON + "task: fly\n", r"s.yaml:2: task: expected global, kidnap or track, got fly"),
    (ON + "kappa: 3\n", r"s.yaml:2: the key 'kappa' belongs to filters"),
    (ON + "filters: [mcl]\ntask: track\n", r"s.yaml:3: the key 'task' belongs to trials without filters"),
    (ON + "filters: [mcl=nothing.yaml]\n", r"s.yaml:2: expected a file, found no .*nothing.yaml"),
    (ON + "a: [\n", r"s.yaml:3: expected YAML"),
    ("trials: 3\n", r"s.yaml:1: expected scenarios or logs"),
    ("scenarios: [no.yaml]\n", r"s.yaml:1: expected a file, found no .*no.yaml"),
    (f"logs:\n  - log: {LOG}\n    map: {MAP}\n", r"s.yaml:2: logs: expected the key 'truth' as well"),
    (f"logs: {{log: {LOG}, map: {MAP}, truth: {TRUTH}}}\ntask: kidnap\n", r"s.yaml:2: task: expected global or track"),
    (f"logs: {{log: {LOG}, map: {MAP}, truth: {TRUTH}}}\nfov: 90\n", r"s.yaml:2: fov is simulated"),
])
def test_what_is_wrong_with_a_plan_is_named_with_its_line(read, text, error):
    with pytest.raises(parloc.ConfigError, match=error):
        read(text)


def test_no_file_and_too_many_points(read, tmp_path):
    with pytest.raises(parloc.InputError, match="nothing.yaml: cannot be read"):
        read_plan(tmp_path / "nothing.yaml")
    many = "{from: 0, to: 1, steps: 1000}"
    with pytest.raises(parloc.ConfigError, match="at most 100000 points"):
        read(ON + f"settings:\n  motion.alpha1: {many}\n  motion.alpha2: {many}\n")


def test_table(tmp_path):
    table = Table({"a": [1, 2], "b": [0.1, None], "c": [True, False]})
    table.save(tmp_path / "t.csv")
    assert (tmp_path / "t.csv").read_text() == "a,b,c\n1,0.1,true\n2,,false\n"
    assert list(table)[1] == table[1] == {"a": 2, "b": None, "c": False} and len(table[0:9]) == 2
    with pytest.raises(parloc.UsageError, match="ends in .csv or .parquet"):
        table.save(tmp_path / "t.txt")
    with pytest.raises(parloc.OutputError, match="cannot be written"):
        table.save(tmp_path / "nowhere" / "t.csv")
    pandas = pytest.importorskip("pandas")
    assert table.to_pandas()["a"].tolist() == [1, 2]
    pytest.importorskip("pyarrow")
    table.save(tmp_path / "t.parquet")
    assert pandas.read_parquet(tmp_path / "t.parquet")["c"].tolist() == [True, False]


def test_effects_are_those_that_were_put_in():
    """Success is worse by 0.5 with b = 2; every trial has its own level, which pairing takes out of the error's interval."""
    columns = {name: [] for name in ("point", "source", "seed", "success", "error_m")}
    points = [{"a": a, "b": b} for a in (1, 2) for b in (1, 2)]
    for k, point in enumerate(points, 1):
        for seed in range(40):
            ok = point["b"] == 1 or seed % 2 == 0
            for name, value in zip(columns, (k, "s", seed, ok, 0.01 * seed + 0.1 * point["a"]), strict=True):
                columns[name].append(value)
    scores = effects.Scores(Table(columns))
    b1, b2 = scores.effects([p["b"] for p in points], None)
    assert (b1.success.mean, b2.success.mean) == (1.0, 0.5) and b2.success.high < b1.success.low
    a1, a2 = scores.effects([p["a"] for p in points], None)
    assert a1.success.mean == a2.success.mean and a2.error_m.mean - a1.error_m.mean == pytest.approx(0.1)
    assert a1.error_m.high - a1.error_m.low < 1e-9 and a1.error_m.count == 40
    best = scores.points()
    assert [p.point for p in best] == [1, 3, 2, 4] and [p.as_good for p in best] == [True, False, False, False]
    assert best[2].behind.mean == -0.5 and best[2].success.mean == 0.5


def test_statistics():
    stats = pytest.importorskip("scipy.stats")
    for degrees in (1, 2, 3, 4, 10, 100):
        assert intervals.t_95(degrees) == pytest.approx(stats.t.ppf(0.975, degrees), rel=0.01)
    interval = effects.wilson(8, 10)
    expected = stats.binomtest(8, 10).proportion_ci(method="wilson")
    assert (interval.low, interval.high) == pytest.approx((expected.low, expected.high), rel=1e-6)
    assert [g[0] for g in effects.grouped(list(range(100)))] == ["0 to 19", "20 to 39", "40 to 59", "60 to 79", "80 to 99"]
    assert [g[0] for g in effects.grouped(["x", "y", "x"])] == ["x", "y"]


def test_nothing_is_imported_before():
    code = "import sys, parloc; print([m for m in ('yaml', 'matplotlib', 'distributed', 'pyarrow') if m in sys.modules])"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.strip() == "[]"


def test_the_example_of_the_guide(read):
    text = (ROOT / "docs" / "sweeps.md").read_text().split("```yaml\n")[1].split("```")[0]
    plan = read(text.replace("configs/", f"{ROOT}/configs/"))
    assert len(plan.points) == 12 and plan.trials == 1200
