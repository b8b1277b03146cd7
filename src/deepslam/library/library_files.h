// The files of a library folder (layout in furniture_library.h).
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "deepslam/core/result.h"
#include "deepslam/scene/model_library.h"

namespace deepslam::library {

// Writes the library beside `folder` and moves it into place as a whole; sets the checksums of
// `library`. An existing `folder` is replaced only if it is a library or empty. `licence_texts`: by
// catalogue name.
[[nodiscard]] Status WriteLibrary(ModelLibrary& library,
                                  const std::map<std::string, std::string>& licence_texts,
                                  const std::filesystem::path& folder);

// The line that credits a model: "name by creator, licence".
[[nodiscard]] std::string CreditLine(const LibraryModel& model);

}  // namespace deepslam::library
