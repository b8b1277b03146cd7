// The package of Universal Scene Description (.usdz): a zip archive whose files are stored as they
// are, each beginning at a multiple of 64 bytes, the scene first.
#pragma once

#include <span>
#include <string>

#include "deepslam/core/result.h"

namespace deepslam::usd {

struct PackagedFile {
  std::string name;  // with its ending; the first one is what readers open
  std::string bytes;
};

// Same files, same bytes. Error: more than 4 GB, which a zip of this kind cannot hold.
[[nodiscard]] Result<std::string> WriteUsdz(std::span<const PackagedFile> files);

}  // namespace deepslam::usd
