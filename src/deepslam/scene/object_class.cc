#include "deepslam/scene/object_class.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace deepslam {

const ObjectClass* ClassTable::Find(std::string_view name) const {
  const auto it = std::find_if(
      classes.begin(), classes.end(), [&](const ObjectClass& c) { return c.name == name; });
  return it == classes.end() ? nullptr : &*it;
}

const ObjectClass* ClassTable::FindByLabel(std::string_view detector_label) const {
  for (const ObjectClass& c : classes) {
    if (std::find(c.detector_labels.begin(), c.detector_labels.end(), detector_label) !=
        c.detector_labels.end()) {
      return &c;
    }
  }
  return nullptr;
}

const ObjectClass* ClassTable::Fallback() const {
  const auto it = std::find_if(
      classes.begin(), classes.end(), [](const ObjectClass& c) { return c.traits.fallback; });
  return it == classes.end() ? nullptr : &*it;
}

ClassTraits ClassTable::TraitsOf(std::string_view name) const {
  const ObjectClass* const known = Find(name);
  return known == nullptr ? ClassTraits() : known->traits;
}

Rgb8 ClassColour(const ClassTable& classes, std::string_view class_name) {
  const ObjectClass* known = classes.Find(class_name);
  if (known == nullptr) return {160, 160, 160};
  const auto channel = [&](std::size_t n) {
    return static_cast<std::uint8_t>(std::clamp(known->colour_rgb[n], 0, 255));
  };
  return {channel(0), channel(1), channel(2)};
}

}  // namespace deepslam
