// A check of a command's option: a number from `low` to `high`. CLI11's own range lets NaN pass.
#pragma once

namespace CLI {
class Validator;
}

namespace deepslam::tools {

[[nodiscard]] CLI::Validator NumberFrom(double low, double high);

}  // namespace deepslam::tools
