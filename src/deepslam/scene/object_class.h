// The classes of objects the map may hold: how detectors call them and how large they are in the
// real world.
//
// One table, read from configs/classes.yaml; adding a class is adding an entry there (and, where
// there is one, a prior).
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace deepslam {

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
};

struct ClassTable {
  std::vector<ObjectClass> classes;

  [[nodiscard]] const ObjectClass* Find(std::string_view name) const;
  // Class for a detector's label; nullptr when the label means nothing to the map.
  [[nodiscard]] const ObjectClass* FindByLabel(std::string_view detector_label) const;
};

// Objects that stand on the floor but whose class is unknown.
inline constexpr std::string_view kFurnitureClass = "furniture";

}  // namespace deepslam
