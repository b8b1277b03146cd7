#include <fstream>
#include <string_view>

#include "deepslam/library/furniture_library.h"

namespace deepslam::library {
namespace {

std::string_view Trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r";
  const std::size_t begin = text.find_first_not_of(kBlank);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlank) - begin + 1);
}

}  // namespace

// Only the `id:` lines matter, so a line reader does; ids hold a '#', which is no comment inside
// quotes.
Result<std::vector<std::string>> ReadWithheldModels(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) return InvalidInput(file.string() + ": cannot be read");
  std::vector<std::string> ids;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    std::string_view text = Trimmed(line);
    if (text.starts_with("- ")) text = Trimmed(text.substr(2));
    if (!text.starts_with("id:")) continue;
    text = Trimmed(text.substr(3));
    const std::size_t end = text.starts_with('"') ? text.find('"', 1) : std::string_view::npos;
    if (end == std::string_view::npos || end == 1) {
      return InvalidConfig(file.string() + ":" + std::to_string(number) +
                           ": id must stand in double quotes, as in id: \"Scopia#chair\"");
    }
    ids.emplace_back(text.substr(1, end - 1));
  }
  return ids;
}

}  // namespace deepslam::library
