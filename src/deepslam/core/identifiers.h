// Names that every format of scenes takes: letters of ASCII, digits and underscores, no digit in
// front.
#pragma once

#include <set>
#include <string>
#include <string_view>

namespace deepslam {

// ASCII letters, digits and underscores stay; every other code point becomes `_u` and its number in
// four to six hexadecimal digits ("Küche 2" is "K_u00FCche_u00202"). `_` comes before a digit in
// front, and stands for an empty name. Bytes that are no UTF-8 are taken for U+FFFD.
[[nodiscard]] std::string IdentifierOf(std::string_view name);

// Identifiers that are given out once: the second of two that would be the same ends with `_2`, the
// third with `_3`. The same names in the same order give the same identifiers.
class Identifiers {
 public:
  [[nodiscard]] std::string Take(std::string_view name);

 private:
  std::set<std::string> taken_;
};

}  // namespace deepslam
