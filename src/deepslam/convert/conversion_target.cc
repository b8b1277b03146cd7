#include "deepslam/convert/conversion_target.h"

#include <unistd.h>

#include <utility>

#include <fmt/format.h>

namespace deepslam::convert {

namespace fs = std::filesystem;

Aside::Aside(fs::path to)
    : to_(std::move(to)), path_(to_.string() + fmt::format(".partial-{}", ::getpid())) {
  Remove();
}

Status Aside::Commit() {
  std::error_code code;
  fs::remove(to_, code);  // an empty folder
  fs::rename(path_, to_, code);
  if (code)
    return Failed(fmt::format("{}: cannot be put in place ({})", to_.string(), code.message()));
  return Ok();
}

void Aside::Remove() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

Status CheckTarget(const fs::path& to, const OutputFormat& format) {
  std::error_code code;
  if (format.is_file && to.extension() != ".sens") {
    return InvalidConfig(fmt::format(
        "{}: {} is one file; give it a name that ends with .sens", to.string(), format.name));
  }
  const bool is_empty_folder =
      !format.is_file && fs::is_directory(to, code) && fs::is_empty(to, code);
  if (fs::exists(fs::symlink_status(to, code)) && !is_empty_folder) {
    return InvalidConfig(fmt::format("{}: exists{}; name a new one or remove it",
                                     to.string(),
                                     format.is_file ? "" : " and is not an empty folder"));
  }
  return Ok();
}

}  // namespace deepslam::convert
