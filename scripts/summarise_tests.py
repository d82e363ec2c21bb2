#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Counts the test cases of a run of ctest over catkin's tests and closes with 'N passed, N failed[, N skipped]'.

Every gtest case counts, alone or inside a rostest; so does every other ctest test, and every test program that failed without a
failed case to show for it: crashed, timed out, or broken by a sanitizer on its way out. Exit status 0 if something ran and
nothing failed.
"""
import pathlib
import sys
import xml.etree.ElementTree as ElementTree


def outcome(case):
    if case.find("failure") is not None or case.find("error") is not None:
        return "failed"
    return "skipped" if case.find("skipped") is not None else "passed"


def cases(path):
    """(name, outcome) of every test case of a JUnit file; a file cut short is a failure."""
    try:
        tree = ElementTree.parse(path)
    except ElementTree.ParseError as error:
        return [(f"{path.name}: {error}", "failed")]
    return [(f"{path.stem}: {c.get('classname')}.{c.get('name')}", outcome(c)) for c in tree.iter("testcase")]


def count(results):
    counted, failed_in = [], {}
    for path in sorted(results.glob("*/*.xml")):
        # A rostest's own file has one case per test node. The node's gtest cases stand in its rosunit file, so that
        # only a node that failed to run adds something.
        found = [c for c in cases(path) if not path.name.startswith("rostest-") or c[1] == "failed"]
        counted += found
        failed_in[path.stem.replace("MISSING-", "")] = any(c[1] == "failed" for c in found)
    a_ros_case_failed = any(failed for stem, failed in failed_in.items() if stem.startswith(("rostest-", "rosunit-")))
    for test in ElementTree.parse(results / "ctest.xml").iter("testcase"):
        name, status = test.get("name"), test.get("status")
        if "_gtest_" in name:
            explained = failed_in.get("gtest-" + name.split("_gtest_", 1)[1], False)
        elif "_rostest_" in name:
            explained = a_ros_case_failed
        else:
            counted.append((name, {"run": "passed", "fail": "failed"}.get(status, "skipped")))
            continue
        if status == "fail" and not explained:
            counted.append((name, "failed"))
    return counted


def main():
    counted = count(pathlib.Path(sys.argv[1]))
    print()
    for kind in ("skipped", "failed"):
        for name, result in counted:
            if result == kind:
                print(f"{kind}: {name}")
    passed, failed, skipped = (sum(result == kind for _, result in counted) for kind in ("passed", "failed", "skipped"))
    print(f"{passed} passed, {failed} failed" + (f", {skipped} skipped" if skipped else ""))
    return 0 if passed and not failed else 1


if __name__ == "__main__":
    sys.exit(main())
