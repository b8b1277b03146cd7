// Where Debian's package of furniture catalogues puts them.
#pragma once

namespace deepslam::tools {

inline constexpr const char* kCatalogueFolder = "/usr/share/sweethome3d/furniture";

}  // namespace deepslam::tools
