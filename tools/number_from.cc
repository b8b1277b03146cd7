#include "number_from.h"

#include <cmath>
#include <cstdlib>
#include <string>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

namespace deepslam::tools {

CLI::Validator NumberFrom(double low, double high) {
  const CLI::Range range(low, high);
  const auto check = [=](std::string& text) {
    if (!std::isnan(std::strtod(text.c_str(), nullptr))) return range(text);
    return fmt::format("{} is no number from {} to {}", text, low, high);
  };
  return {check, range.get_description()};
}

}  // namespace deepslam::tools
