// Options described once: parse, dump, range check, documentation and hash key all come from one
// Describe() per struct.
//
// Beside every algorithm stands `struct XOptions` with in-class defaults and
//   void Describe(OptionsVisitor& visitor, XOptions& options);
// which names each field once with its unit, range and meaning. Visitors read YAML, print, check or
// hash.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace deepslam {

// Inclusive bounds of a numeric option.
struct Range {
  double min = 0;
  double max = 0;
};

class OptionsVisitor {
 public:
  virtual ~OptionsVisitor() = default;

  // `unit` is "m", "rad", "deg", "px", "s", "1" (dimensionless) ...; `help` is one line.
  virtual void Field(std::string_view name,
                     double& value,
                     Range range,
                     std::string_view unit,
                     std::string_view help) = 0;
  virtual void Field(std::string_view name,
                     int& value,
                     Range range,
                     std::string_view unit,
                     std::string_view help) = 0;
  virtual void Field(std::string_view name, bool& value, std::string_view help) = 0;
  virtual void Field(std::string_view name, std::string& value, std::string_view help) = 0;
  // A string out of a closed set.
  virtual void Choice(std::string_view name,
                      std::string& value,
                      std::span<const std::string_view> choices,
                      std::string_view help) = 0;
  // An option that there was: whoever still sets it is told what to do now (`instead`, a clause
  // that follows "... is no option any more: "). Those who list options pass over it.
  virtual void Retired(std::string_view /*name*/, std::string_view /*instead*/) {}
};

}  // namespace deepslam
