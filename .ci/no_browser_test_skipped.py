"""Fail if a browser test was skipped: python no_browser_test_skipped.py JUNIT.xml"""

import sys
import xml.etree.ElementTree as ET

cases = [c for c in ET.parse(sys.argv[1]).iter("testcase") if "browser" in c.get("classname", "")]
skipped = [c.get("name") for c in cases if c.find("skipped") is not None]
if not cases or skipped:
    sys.exit(f"browser tests: {len(cases)} run, skipped: {skipped}")
print(f"browser tests: {len(cases)} run, none skipped")
