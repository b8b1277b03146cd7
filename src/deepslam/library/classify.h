// Which class of the map a catalogue item belongs to, by its name and size.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "deepslam/library/catalogue.h"

namespace deepslam::library {

// "chair", "table", "sofa", "bed", "cabinet" or "shelf"; nothing for everything else (lamps, doors,
// wall units, toys). Armchairs and stools are chairs, desks are tables, wardrobes and drawers are
// cabinets.
[[nodiscard]] std::optional<std::string> ClassOfItem(const CatalogueItem& item);

// Whether furniture of such a class has a back, by which its front is told.
[[nodiscard]] bool HasBack(std::string_view class_name);

}  // namespace deepslam::library
