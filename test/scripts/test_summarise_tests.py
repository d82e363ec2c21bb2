#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""What scripts/test counts: the judge of all other tests."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "scripts" / "summarise_tests.py"
PASSED = '<testcase classname="A" name="passes"/>'
FAILED = '<testcase classname="A" name="fails"><failure message="1 is not 2"/></testcase>'
SKIPPED = '<testcase classname="A" name="skips"><skipped message="no data"/></testcase>'


def ctest(name, status):
    return f'<testcase name="{name}" status="{status}"/>'


class SummariseTests(unittest.TestCase):
    def summarise(self, ctest_cases, **files):
        """(last line, exit status) for a result folder of the given files: name -> test cases."""
        with tempfile.TemporaryDirectory() as folder:
            results = pathlib.Path(folder)
            (results / "package").mkdir()
            (results / "ctest.xml").write_text(f"<testsuite>{''.join(ctest_cases)}</testsuite>")
            for name, cases in files.items():
                (results / "package" / (name.replace("_", "-", 1) + ".xml")).write_text(f"<testsuite>{cases}</testsuite>")
            run = subprocess.run([sys.executable, SCRIPT, folder], stdout=subprocess.PIPE, text=True, timeout=60)
        return run.stdout.splitlines()[-1], run.returncode

    def test_counts_gtest_cases_and_plain_tests(self):
        cases = [ctest("_ctest_package_gtest_a", "run"), ctest("tool", "run")]
        self.assertEqual(self.summarise(cases, gtest_a=PASSED + PASSED + SKIPPED), ("3 passed, 0 failed, 1 skipped", 0))

    def test_counts_the_cases_inside_a_rostest_once(self):
        cases = [ctest("_ctest_package_rostest_a.test", "run")]
        self.assertEqual(self.summarise(cases, rostest_a=PASSED, rosunit_node=PASSED + PASSED), ("2 passed, 0 failed", 0))

    def test_a_failed_case_fails_the_run_and_counts_once(self):
        cases = [ctest("_ctest_package_gtest_a", "fail"), ctest("_ctest_package_rostest_a.test", "fail")]
        self.assertEqual(self.summarise(cases, gtest_a=PASSED + FAILED, rostest_a=PASSED, rosunit_node=FAILED),
                         ("1 passed, 2 failed", 1))

    def test_a_program_that_fails_after_its_cases_passed_is_a_failure(self):
        cases = [ctest("_ctest_package_gtest_a", "fail")]
        self.assertEqual(self.summarise(cases, gtest_a=PASSED), ("1 passed, 1 failed", 1))

    def test_a_program_without_results_is_a_failure(self):
        cases = [ctest("_ctest_package_gtest_a", "fail"), ctest("_ctest_package_rostest_a.test", "fail"), ctest("tool", "fail")]
        self.assertEqual(self.summarise(cases, gtest_b=PASSED), ("1 passed, 3 failed", 1))

    def test_a_node_that_did_not_run_is_a_failure(self):
        cases = [ctest("_ctest_package_rostest_a.test", "fail")]
        self.assertEqual(self.summarise(cases, rostest_a=PASSED + FAILED, rosunit_node=PASSED), ("1 passed, 1 failed", 1))

    def test_a_result_file_cut_short_is_a_failure(self):
        cases = [ctest("_ctest_package_gtest_a", "run")]
        self.assertEqual(self.summarise(cases, gtest_a="<testcase", gtest_b=PASSED), ("1 passed, 1 failed", 1))

    def test_nothing_run_is_no_success(self):
        self.assertEqual(self.summarise([]), ("0 passed, 0 failed", 1))
        self.assertEqual(self.summarise([ctest("_ctest_package_gtest_a", "run")], gtest_a=SKIPPED),
                         ("0 passed, 0 failed, 1 skipped", 1))


if __name__ == "__main__":
    unittest.main()
