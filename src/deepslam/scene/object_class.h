// The classes of objects the map may hold: how detectors call them, how large they are in the real
// world, and what algorithms have to know of them.
//
// One table, read from configs/classes.yaml; adding a class is adding an entry there (and, where
// there is one, a prior). No algorithm knows a class by its name: it asks for a trait.
#pragma once

#include <array>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/core/image.h"

namespace deepslam {

// Beds, tables and desks hide what stands behind them up to this height above the floor; what
// begins higher stands on something else than the floor, or hangs.
inline constexpr double kMaxHiddenBase_m = 0.75;

// What things of a class rest on; one of them at least.
struct Supports {
  bool floor = true;
  bool furniture = false;
  bool wall = false;

  [[nodiscard]] bool operator==(const Supports&) const = default;
  // Whether a thing whose foot is this far above the floor rests on something else than the floor.
  [[nodiscard]] bool RestsElsewhere(double foot_m, double max_gap_m) const {
    return (furniture || wall) && (!floor || foot_m > max_gap_m);
  }
};

// What a label set of the field calls a class.
struct ClassLabel {
  int id = 0;
  std::string name;

  [[nodiscard]] bool operator==(const ClassLabel&) const = default;
};
struct CommonLabels {
  std::optional<ClassLabel> coco;        // categories of COCO 2017
  std::optional<ClassLabel> nyu40;       // NYU Depth v2, 40 classes
  std::optional<ClassLabel> scannet200;  // ScanNet200

  [[nodiscard]] bool operator==(const CommonLabels&) const = default;
};

// What simulators have to know of things of a class.
struct ClassPhysics {
  // Mass over the volume of the closed surface, what is hollow in it included. The default is that
  // of light wooden furniture.
  double density_kg_m3 = 200;
  bool fixed = false;  // to the building, so that it never moves

  [[nodiscard]] bool operator==(const ClassPhysics&) const = default;
};

// The defaults are what holds for a class that nothing is said of.
struct ClassTraits {
  Supports supports = {};
  // A level support plane and what carries it: such an object is what lies at the height of the
  // plane or under it, never what stands on it or before it.
  bool support_plane = false;
  // Closed furniture: what no view sees inside it is solid; of others only a shell behind the seen
  // surface is.
  bool solid_inside = false;
  // Alike from several sides: two observations may see its front differently.
  bool yaw_free = false;
  // Takes what fits no other class, and any library model of its size; one class at most.
  bool fallback = false;
  // Let into furniture, as basins are: the piece of furniture under it is one thing with it.
  bool built_in = false;
  // No prior knows its shape: it is what was measured of it, whatever a library or a network holds.
  bool fused_only = false;

  [[nodiscard]] bool operator==(const ClassTraits&) const = default;
};

struct ObjectClass {
  std::string name;  // "chair"; lower case, becomes part of node names
  std::vector<std::string>
      detector_labels;  // labels of detectors that mean this class ("couch", "dining table")
  std::vector<std::string>
      library_classes;  // classes of the CAD library whose models may stand for it
  // Longest side of real objects (of the model's box), metres.
  double min_size_m = 0.2;
  double max_size_m = 3.0;
  // Height above the ground of real objects, metres.
  double min_height_m = 0.2;
  double max_height_m = 2.5;
  std::array<int, 3> colour_rgb = {160, 160, 160};  // class colour in pictures and scenes
  ClassTraits traits;
  CommonLabels labels_elsewhere = {};
  ClassPhysics physics = {};
  // Shorter side of the footprint of real objects, metres; of what no detector names.
  double max_depth_m = std::numeric_limits<double>::infinity();
  // Of seats: what has a level face over most of it that lies higher is none of the class, metres.
  double max_seat_height_m = std::numeric_limits<double>::infinity();
};

struct ClassTable {
  std::vector<ObjectClass> classes;

  [[nodiscard]] const ObjectClass* Find(std::string_view name) const;
  // Class for a detector's label; nullptr when the label means nothing to the map.
  [[nodiscard]] const ObjectClass* FindByLabel(std::string_view detector_label) const;
  // The class of what fits no other; nullptr where the table has none.
  [[nodiscard]] const ObjectClass* Fallback() const;
  // The defaults for a name that is not in the table.
  [[nodiscard]] ClassTraits TraitsOf(std::string_view name) const;
};

// The class's colour in pictures and scenes, sRGB; grey for classes that the table does not know.
[[nodiscard]] Rgb8 ClassColour(const ClassTable& classes, std::string_view class_name);

}  // namespace deepslam
