"""tools/gpu_check where there is no GPU or a tool is missing, and how it holds measured steps against the model."""

import importlib.machinery
import importlib.util
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "tools/gpu_check"


def load():
    loader = importlib.machinery.SourceFileLoader("gpu_check", str(PROGRAM))
    spec = importlib.util.spec_from_loader("gpu_check", loader)
    module = importlib.util.module_from_spec(spec)
    sys.modules["gpu_check"] = module
    loader.exec_module(module)
    return module


class GpuCheck(unittest.TestCase):
    def answer(self, tools):
        """With these programs on PATH, each a line of shell."""
        with tempfile.TemporaryDirectory() as folder:
            for name, line in tools.items():
                file = pathlib.Path(folder) / name
                file.write_text(f"#!/bin/sh\n{line}\n")
                file.chmod(0o755)
            command = [sys.executable, "-B", PROGRAM, "--out", pathlib.Path(folder) / "out"]
            done = subprocess.run(command, env={**os.environ, "PATH": folder}, capture_output=True, text=True, timeout=60)
            self.assertFalse((pathlib.Path(folder) / "out").exists())
        return done

    def expect_line(self, tools, words):
        done = self.answer(tools)
        self.assertEqual(done.returncode, 6)
        self.assertEqual(done.stdout, "")
        self.assertEqual(done.stderr.count("\n"), 1)
        self.assertIn(words, done.stderr)

    def test_says_in_one_line_what_is_missing(self):
        others = {name: "exit 0" for name in ("nvcc", "compute-sanitizer", "cmake", "ninja", "ctest")}
        self.expect_line({}, "nvidia-smi was not found")
        self.expect_line({"nvidia-smi": "echo 'GPU 0: X (UUID: y)'"}, "not on PATH: nvcc, compute-sanitizer")
        self.expect_line({**others, "nvidia-smi": "echo 'No devices were found'; exit 6"}, "no GPU answers")

    def test_finds_the_estimates_of_a_gpu(self):
        module = load()
        found = module.estimates("GPU 0: NVIDIA H200")
        for key in (("hall", "beam", "4000"), ("hall", "likelihood_field", "4000"), ("faculty", "scan_match", "1000")):
            self.assertGreater(found[key], 10.0)
        self.assertEqual(module.estimates("GPU 0: NVIDIA T4"), {})

    def test_holds_steps_against_them(self):
        measured = {"step/beam/skip/cuda/particles:4000/beams:200/manual_time": 150.0,
                    "step/gaussian/cuda/particles:1000/beams:180/threads:1/real_time": 9.0}  # fmt: skip
        rows = load().beside_model(measured, {("hall", "beam", "4000"): 100.0, ("faculty", "gaussian", "1000"): 7.0})
        self.assertEqual(rows, [("beam, 4000 particles", 150.0, 100.0), ("gaussian, 1000 particles", 9.0, 7.0)])


if __name__ == "__main__":
    unittest.main()
