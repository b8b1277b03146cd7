#include "deepslam/batch/capture_list.h"

#include <glob.h>

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "deepslam/artifact/json_value.h"
#include "deepslam/storage/store.h"

namespace deepslam::batch {
namespace {

namespace fs = std::filesystem;

// 64 MiB; a recording given by mistake is not read whole.
constexpr std::size_t kMaxListBytes = std::size_t{64} << 20;
constexpr std::size_t kMaxNameBytes = 120;     // leaves room for the longest file in a workspace
constexpr std::size_t kMaxCollisionsTold = 5;  // the rest is one line with their number
constexpr std::string_view kWildcards = "*?[";

bool IsUtf8(const std::string& text) {
  return artifact::DumpJson(artifact::JsonValue(text), "").ok();
}

bool HasWildcard(std::string_view text) {
  return text.find_first_of(kWildcards) != std::string_view::npos;
}

bool MayStandInName(unsigned char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
         c == '_' || c == '-' || c >= 0x80;
}

std::string Sanitised(std::string text) {
  for (char& c : text) {
    if (!MayStandInName(static_cast<unsigned char>(c))) c = '_';
  }
  if (!text.empty() && (text.front() == '.' || text.front() == '-')) text.front() = '_';
  return text;
}

fs::path Absolute(const fs::path& path) {
  std::error_code error;
  fs::path absolute = fs::absolute(path, error).lexically_normal();
  return absolute.has_filename() ? absolute : absolute.parent_path();  // no slash at the end
}

// Recordings of one file go by their stem; `room.v2` as a folder keeps its whole name.
std::string LastName(const fs::path& path) {
  return path.extension() == ".sens" ? path.stem().string() : path.filename().string();
}

// By the parts of the path from the first wildcard on; what `folder` is called is no wildcard.
std::string NameUnderPattern(const fs::path& path,
                             const fs::path& pattern,
                             const fs::path& folder) {
  std::string name;
  bool wild = false;
  bool in_folder = true;
  auto part = path.begin();
  auto given = folder.begin();
  for (const fs::path& wanted : pattern) {
    if (part == path.end()) break;
    in_folder = in_folder && given != folder.end() && *given == wanted;
    if (in_folder) ++given;
    wild = wild || (!in_folder && HasWildcard(wanted.string()));
    if (wild) {
      const bool last = std::next(part) == path.end();
      name = fmt::format(
          "{}{}{}", name, name.empty() ? "" : "_", last ? LastName(*part) : part->string());
    }
    ++part;
  }
  return Sanitised(name);
}

// For glob: what the folders are called in which a pattern stands is no pattern.
std::string Escaped(const fs::path& folder) {
  std::string escaped;
  for (const char c : folder.string()) {
    if (c == '\\' || kWildcards.find(c) != std::string_view::npos) escaped += '\\';
    escaped += c;
  }
  return escaped;
}

bool IsCapture(const fs::path& path) {
  std::error_code error;
  return fs::is_directory(path, error) || path.extension() == ".sens";
}

Error AtPlace(std::string_view place, std::string_view what) {
  return InvalidInput(fmt::format("{}: {}", place, what));
}

Result<std::vector<ListedCapture>> Expand(const fs::path& pattern,
                                          const std::string& place,
                                          const fs::path& folder) {
  const fs::path absolute = Absolute(folder / pattern);
  const fs::path wanted = Absolute(fs::path(Escaped(folder)) / pattern);
  glob_t found{};
  const int outcome = ::glob(wanted.c_str(), 0, nullptr, &found);
  std::vector<ListedCapture> captures;
  for (std::size_t i = 0; outcome == 0 && i < found.gl_pathc; ++i) {
    const fs::path path = found.gl_pathv[i];
    if (IsCapture(path))
      captures.push_back({path, NameUnderPattern(path, absolute, folder), place, true});
  }
  ::globfree(&found);
  if (captures.empty()) {
    return AtPlace(place, fmt::format("{} matches no folder and no .sens file", pattern.string()));
  }
  return captures;
}

// Words of a line; a word in double quotes may hold blanks. Nothing when a quote stays open.
std::optional<std::vector<std::string>> Words(std::string_view line) {
  std::vector<std::string> words;
  std::size_t at = 0;
  while (true) {
    at = line.find_first_not_of(" \t\r", at);
    if (at == std::string_view::npos || line[at] == '#') return words;
    const bool quoted = line[at] == '"';
    if (quoted) ++at;
    const std::size_t end = line.find_first_of(quoted ? "\"" : " \t\r", at);
    if (quoted && end == std::string_view::npos) return std::nullopt;
    words.emplace_back(line.substr(at, end == std::string_view::npos ? end : end - at));
    if (end == std::string_view::npos) return words;
    at = end + (quoted ? 1 : 0);
  }
}

Status CheckGivenName(const std::string& name, const std::string& place) {
  if (name.empty() || name != Sanitised(name)) {
    return AtPlace(
        place,
        fmt::format("'{}' cannot name a workspace: letters, digits, '.', '_' and '-' can, "
                    "with neither '.' nor '-' in front; put quotes around a path with "
                    "blanks in it",
                    name));
  }
  return Ok();
}

Result<std::vector<ListedCapture>> ReadLine(const std::vector<std::string>& words,
                                            const std::string& place,
                                            const fs::path& folder) {
  if (words.size() > 2) {
    return AtPlace(place,
                   fmt::format("{} words, where PATH or PATH NAME is expected; put quotes around a "
                               "path with blanks in it",
                               words.size()));
  }
  if (words.front().empty()) return AtPlace(place, "an empty path");
  const fs::path path = folder / words.front();
  std::error_code error;
  const bool pattern = HasWildcard(words.front()) && !fs::exists(path, error);
  if (words.size() == 1 && pattern) return Expand(words.front(), place, Absolute(folder));
  if (pattern) return AtPlace(place, "a pattern stands for many captures and can have no name");
  const fs::path absolute = Absolute(path);
  if (words.size() == 1)
    return std::vector<ListedCapture>{{absolute, Sanitised(LastName(absolute)), place}};
  if (Status status = CheckGivenName(words[1], place); !status.ok()) return status.error();
  return std::vector<ListedCapture>{{absolute, words[1], place}};
}

Result<std::vector<ListedCapture>> FindOne(const std::string& argument, const std::string& place) {
  std::error_code error;
  const fs::path path = argument;
  if (argument.empty()) return AtPlace(place, "an empty path");
  if (!fs::exists(path, error)) {
    if (HasWildcard(argument)) return Expand(path, place, Absolute("."));
    return InvalidInput(fmt::format("{}: no such list, capture or pattern", argument));
  }
  if (IsCapture(path)) {
    const fs::path absolute = Absolute(path);
    return std::vector<ListedCapture>{{absolute, Sanitised(LastName(absolute)), place}};
  }
  const auto size = fs::file_size(path, error);
  if (!error && size > kMaxListBytes) {
    return InvalidInput(fmt::format("{}: {} bytes are no list of captures", argument, size));
  }
  const Result<std::string> text = storage::ReadFile(path);
  if (!text.ok()) return text.error();
  return ReadCaptureList(*text, argument, Absolute(path).parent_path());
}

// A capture is told by its name when it came in by itself, else by the line it stands in.
std::string Told(const ListedCapture& capture) {
  return fmt::format("{} ({})", capture.path.string(), capture.place);
}

}  // namespace

Result<std::vector<ListedCapture>> ReadCaptureList(std::string_view text,
                                                   std::string_view name,
                                                   const fs::path& folder) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);  // byte order mark
  std::vector<ListedCapture> captures;
  int line_number = 0;
  while (!text.empty()) {
    ++line_number;
    const std::size_t end = text.find('\n');
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    const std::string place = fmt::format("{}:{}", name, line_number);
    if (line.find('\0') != std::string_view::npos)
      return AtPlace(place, "is no text; a list has one path per line");
    const auto words = Words(line);
    if (!words) return AtPlace(place, "a quote is not closed");
    if (words->empty()) continue;
    Result<std::vector<ListedCapture>> found = ReadLine(*words, place, folder);
    if (!found.ok()) return found.error();
    std::move(found->begin(), found->end(), std::back_inserter(captures));
  }
  if (captures.empty()) return AtPlace(name, "names no capture; a list has one path per line");
  return captures;
}

Status CheckNames(std::span<const ListedCapture> captures) {
  std::map<std::string, const ListedCapture*> by_name;
  std::string faults;
  std::size_t num_faults = 0;
  const auto fault = [&](const std::string& text) {
    if (++num_faults <= kMaxCollisionsTold) faults += (faults.empty() ? "" : "\n") + text;
  };
  for (const ListedCapture& capture : captures) {
    if (!IsUtf8(capture.path.string())) {
      return AtPlace(capture.place,
                     "the path of a capture is not UTF-8; rename the folder or link to it");
    }
    if (capture.name.empty() || capture.name.size() > kMaxNameBytes ||
        capture.name == "index.html" || capture.name == "batch.json") {
      fault(
          fmt::format("{}: '{}' cannot name a workspace; give the capture another name in a list "
                      "file (PATH NAME)",
                      Told(capture),
                      capture.name));
      continue;
    }
    const auto [it, fresh] = by_name.emplace(capture.name, &capture);
    if (fresh) continue;
    fault(it->second->path == capture.path
              ? fmt::format("{} stands twice: {} and {}; take one away, or give one a name of its "
                            "own in a list file (PATH NAME)",
                            capture.path.string(),
                            it->second->place,
                            capture.place)
              : fmt::format(
                    "{} and {} would both have the workspace '{}'; give one another name in "
                    "a list file (PATH NAME), or use a pattern in quotes such as 'rooms/*/*', "
                    "which names by the whole of what it matches",
                    Told(*it->second),
                    Told(capture),
                    capture.name));
  }
  if (num_faults > kMaxCollisionsTold)
    faults += fmt::format("\nand {} more", num_faults - kMaxCollisionsTold);
  if (num_faults > 0) return InvalidInput(faults);
  return Ok();
}

Result<std::vector<ListedCapture>> FindCaptures(std::span<const std::string> arguments) {
  std::vector<ListedCapture> captures;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    Result<std::vector<ListedCapture>> found =
        FindOne(arguments[i], fmt::format("argument {}", i + 1));
    if (!found.ok()) return found.error();
    std::move(found->begin(), found->end(), std::back_inserter(captures));
  }
  if (captures.empty()) return InvalidInput("no capture was named");
  if (Status status = CheckNames(captures); !status.ok()) return status.error();
  return captures;
}

}  // namespace deepslam::batch
