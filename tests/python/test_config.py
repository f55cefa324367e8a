"""Configurations: every setting, read, written and refused as in files."""

import copy
import pickle

import pytest
from conftest import ROOT

import parloc


def test_attributes_are_the_settings_of_files():
    config = parloc.Config(particles=500, sensor={"sigma_hit": 0.3, "model": "beam"})
    assert config.particles == config["particles"] == 500
    assert (config.sensor.model, config.sensor.sigma_hit, config.sensor.z_hit) == ("beam", 0.3, 0.75)
    config.sensor.model = "likelihood_field"  # brings its defaults, as in a file
    assert config.sensor.sigma_hit == parloc.Config().sensor.sigma_hit
    config["motion.alpha1"] = 1
    config.scan = {"max_beams": 60}
    assert (config.motion.alpha1, config.scan.max_beams) == (1.0, 60)
    for name in config.names():
        config[name] = config[name]


def test_every_key_of_the_yaml_is_an_attribute():
    config = parloc.Config()
    group = ""
    seen = 0
    for line in str(config).splitlines():
        if not line or line.lstrip().startswith("#"):
            continue
        key = line.split(":")[0]
        if not key.startswith(" "):
            group = key if line.rstrip().endswith(":") else ""
        if line.rstrip().endswith(":"):
            continue
        holder = getattr(config, group) if group else config
        assert hasattr(holder, key.strip()), line
        seen += 1
    assert seen == len(config.names()) > 100


def test_yaml_pickle_and_copies(tmp_path):
    config = parloc.Config(seed=2**64 - 1, lidars={"front": {"x": 0.2, "mask": [(2.5, -2.5)]}}, log={"scan_topic": "/scan"})
    (tmp_path / "c.yaml").write_text(config.to_yaml())
    for twin in (
        parloc.read_config(tmp_path / "c.yaml"),
        parloc.Config.from_yaml(str(config)),
        pickle.loads(pickle.dumps(config)),
        copy.deepcopy(config),
        config.copy(),
    ):
        assert twin == config and str(twin) == str(config)
        twin.lidars["front"].x = 0.3
        assert twin != config and config.lidars["front"].x == 0.2
    assert repr(config) == "<parloc.Config seed=18446744073709551615, log.scan_topic='/scan', 1 LiDARs>"


def test_lidars():
    config = parloc.Config()
    config.lidars["front"] = {"yaw": 1.5}
    front = config.lidars["front"]
    assert (front.yaw, front.x, len(config.lidars), list(config.lidars), "rear" in config.lidars) == (
        1.5, None, 1, ["front"], False,
    )
    with pytest.raises(parloc.ConfigError, match="lidars.front.min_range must be 0 to 1000, got -4"):
        front.min_range = -4
    assert front.min_range is None
    del config.lidars["front"]
    with pytest.raises(KeyError):
        config.lidars["front"]
    with pytest.raises(KeyError, match="there is no LiDAR 'front' any more"):
        _ = front.yaw


def test_nav2():
    parameters = "amcl:\n  ros__parameters:\n    max_particles: 700\n    min_particles: 100\n"
    assert parloc.Config.from_yaml(parameters).max_particles == 700


@pytest.mark.parametrize(
    ("change", "error", "words"),
    [
        (lambda c: setattr(c, "particels", 3), AttributeError, "Config has no setting 'particels'; the nearest is 'particles'"),
        (lambda c: c.sensor.sigmahit, AttributeError, "sensor has no setting 'sigmahit'; the nearest is 'sigma_hit'"),
        (lambda c: c.__setitem__("sensor.modl", 1), KeyError, "the nearest is 'sensor.model'"),
        (lambda c: parloc.Config(partcles=1), parloc.ConfigError, "the nearest is 'particles'"),
        (lambda c: parloc.Config(sensor={"modl": 1}), parloc.ConfigError, "sensor has no setting 'modl'"),
        (lambda c: setattr(c.sensor, "sigma_hit", -1), parloc.ConfigError, "sensor.sigma_hit must be 0.001 to 10, got -1"),
        (lambda c: setattr(c.sensor, "sigma_hit", "a"), TypeError, "sensor.sigma_hit must be 0.001 to 10, got str a"),
        (lambda c: setattr(c, "particles", 1.5), TypeError, "particles must be 1 to 16777216, got float 1.5"),
        (lambda c: setattr(c, "seed", -1), parloc.ConfigError, "seed must be 0 to 18446744073709551615, got -1"),
        (lambda c: setattr(c.sensor, "do_beamskip", 1), TypeError, "true or false, got int 1"),
        (lambda c: setattr(c.sensor, "model", "x"), parloc.ConfigError, "gaussian, s5, beam, .*got x"),
        (lambda c: setattr(c.log, "scan_topic", 3), TypeError, "a text, got int 3"),
        (lambda c: setattr(c, "scan", 3), TypeError, "incompatible"),
        (lambda c: parloc.Config.from_yaml("particels: 3"), parloc.ConfigError, "the text:1: unknown key 'particels'"),
        (lambda c: parloc.read_config(ROOT / "nothing.yaml"), parloc.Error, "nothing.yaml"),
    ],
)
def test_refusals_leave_the_configuration_as_it_was(change, error, words):
    config = parloc.Config()
    with pytest.raises(error, match=words):
        change(config)
    assert config == parloc.Config()


def test_rules_between_settings():
    config = parloc.Config(sensor={"z_hit": 0.9, "z_rand": 0.9})
    with pytest.raises(parloc.ConfigError, match="z_hit"):
        config.validate()
