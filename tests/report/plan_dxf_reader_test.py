#!/usr/bin/env python3
"""The floor plan as a CAD library reads it: ezdxf, which checks what AutoCAD checks.

    plan_dxf_reader_test.py WRITE_PLAN       WRITE_PLAN FILE writes the plan of two rooms (write_plan.cc)
"""
import pathlib
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
import python_packages  # noqa: E402

(ezdxf,) = python_packages.need("ezdxf")
WRITER = pathlib.Path(sys.argv[1]).resolve()


class Plan(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        with tempfile.TemporaryDirectory(prefix="deepslam-plan-") as folder:
            file = pathlib.Path(folder) / "plan.dxf"
            subprocess.run([WRITER, file], check=True, timeout=60)
            cls.drawing = ezdxf.readfile(file)
        cls.entities = list(cls.drawing.modelspace())

    def of(self, layer, kind):
        return [entity for entity in self.entities if entity.dxf.layer == layer and entity.dxftype() == kind]

    def test_is_release_12_without_a_fault(self):
        self.assertEqual(self.drawing.dxfversion, "AC1009")
        audit = self.drawing.audit()
        self.assertEqual([str(error) for error in audit.errors], [])
        self.assertEqual(audit.fixes, [])

    def test_is_in_metres_on_its_layers(self):
        self.assertEqual(self.drawing.header["$INSUNITS"], 6)
        layers = {layer.dxf.name for layer in self.drawing.layers}
        self.assertLessEqual({"WALLS", "DOORS", "WINDOWS", "FURNITURE", "TEXT"}, layers)
        self.assertEqual({entity.dxf.layer for entity in self.entities}, {"WALLS", "DOORS", "WINDOWS", "FURNITURE", "TEXT"})
        low, high = self.drawing.header["$EXTMIN"], self.drawing.header["$EXTMAX"]
        self.assertAlmostEqual(high[0] - low[0], 8.1 + 2 * 0.12 + 0.2, delta=0.3)  # rooms, outer walls, lengths beside them

    def test_shows_the_door_the_window_and_the_table(self):
        (arc,) = self.of("DOORS", "ARC")
        self.assertAlmostEqual(arc.dxf.radius, 0.9, places=3)
        # Hung where the wall's end is nearer, at (4, 1.9) or (4, 1); open into the first room, which lies at x < 4.
        self.assertAlmostEqual(arc.dxf.center.x, 4, places=3)
        middle = arc.dxf.start_angle + ((arc.dxf.end_angle - arc.dxf.start_angle) % 360) / 2
        self.assertTrue(90 < middle % 360 < 270, middle)
        (table,) = self.of("FURNITURE", "POLYLINE")
        self.assertTrue(table.is_closed)
        corners = [vertex.dxf.location for vertex in table.vertices]
        self.assertAlmostEqual(max(p.x for p in corners) - min(p.x for p in corners), 0.8, places=3)
        self.assertAlmostEqual(max(p.y for p in corners) - min(p.y for p in corners), 1.6, places=3)
        window = self.of("WINDOWS", "LINE")
        self.assertAlmostEqual(max(line.dxf.start.x for line in window), 7, places=3)
        self.assertEqual([line.dxf.linetype for line in self.of("WALLS", "LINE") if line.dxf.linetype == "DASHED"], ["DASHED"])
        self.assertIn("Room 1", [text.dxf.text for text in self.of("TEXT", "TEXT")])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
