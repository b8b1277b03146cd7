// The item list of a furniture catalogue.
#include "deepslam/library/catalogue.h"
#include "fuzz/entry.h"

DEEPSLAM_FUZZ(catalogue) {
  const Result<library::Catalogue> catalogue = library::ParseCatalogue(bytes);
  if (!catalogue.ok()) return false;
  bool usable = false;
  for (const library::CatalogueItem& item : catalogue->items) {
    if (!item.fault.empty()) continue;
    usable = true;
    DEEPSLAM_CHECK(item.width_m > 0 && item.depth_m > 0 && item.height_m > 0,
                   "furniture has a size");
    DEEPSLAM_CHECK(item.rotation.allFinite(), "a rotation is finite");
  }
  return usable;
}
