#include "deepslam/formats/text_lines.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include <fmt/format.h>

namespace deepslam::formats {
namespace {

constexpr std::size_t kMaxShownChars = 80;  // as much of a faulty line as a message quotes

}  // namespace

std::string Shown(std::string_view text) {
  std::string shown(text.substr(0, kMaxShownChars));
  for (char& c : shown) {
    if (static_cast<unsigned char>(c) < 0x20) c = '?';
  }
  return shown;
}

LineReader::LineReader(std::string_view text) : left_(text) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (left_.starts_with(kByteOrderMark)) left_.remove_prefix(kByteOrderMark.size());
  // Old Macs end lines by a carriage return alone.
  if (left_.find('\n') == std::string_view::npos) line_end_ = '\r';
}

const TextLine* LineReader::Next() {
  while (!left_.empty()) {
    const std::size_t end = left_.find(line_end_);
    std::string_view line = left_.substr(0, end);
    left_.remove_prefix(end == std::string_view::npos ? left_.size() : end + 1);
    ++line_.number;
    line_.unfinished = end == std::string_view::npos;
    line_.fields.clear();
    constexpr std::string_view kBlank = " \t\r,";
    while (true) {
      const std::size_t begin = line.find_first_not_of(kBlank);
      if (begin == std::string_view::npos) break;
      line.remove_prefix(begin);
      const std::size_t length = std::min(line.find_first_of(kBlank), line.size());
      line_.fields.push_back(line.substr(0, length));
      line.remove_prefix(length);
    }
    if (!line_.fields.empty() && !line_.fields.front().starts_with('#')) return &line_;
  }
  return nullptr;
}

std::vector<TextLine> SplitLines(std::string_view text) {
  std::vector<TextLine> lines;
  LineReader reader(text);
  while (const TextLine* const line = reader.Next()) lines.push_back(*line);
  return lines;
}

Error LineError(const std::filesystem::path& file, int line, std::string_view fault) {
  return InvalidInput(fmt::format("{}:{}: {}", file.string(), line, fault));
}

bool IsLeftOut(const std::filesystem::path& file,
               const TextLine& line,
               std::vector<std::string>& warnings) {
  if (!line.unfinished) return false;
  warnings.push_back(fmt::format(
      "{}:{}: the file ends within this line (was the recorder stopped?); it was left out",
      file.string(),
      line.number));
  return true;
}

Error TimeError(const std::filesystem::path& file,
                int line,
                std::string_view name,
                std::string_view field) {
  struct Unit {
    double least;  // of today's time since 1970 in it
    std::string_view words;
  };
  // Clocks that run since a device was started count nanoseconds from 1e11 (two minutes) on.
  constexpr std::array<Unit, 5> kUnits = {
      {{1e17, "nanoseconds; divide them by 1000000000"},
       {1e15, "microseconds; divide them by 1000000"},
       {1e14, "nanoseconds since the device was started; divide them by 1000000000"},
       {1e12,
        "milliseconds; divide them by 1000 (or nanoseconds since the device was started: by "
        "1000000000)"},
       {1e11, "nanoseconds since the device was started; divide them by 1000000000"}}};
  const double size = std::abs(ParseNumber(field).value_or(0));
  for (const Unit& unit : kUnits) {
    if (!(size >= unit.least && size < 1e20)) continue;
    return LineError(
        file,
        line,
        fmt::format("field '{}' is '{}': times have to be in seconds, these look like {}",
                    name,
                    Shown(field),
                    unit.words));
  }
  return LineError(
      file,
      line,
      fmt::format("field '{}' is '{}', not a time in seconds: correct or remove the line",
                  name,
                  Shown(field)));
}

Status CheckFieldCount(const std::filesystem::path& file,
                       const TextLine& line,
                       std::size_t count,
                       std::string_view layout) {
  if (line.fields.size() == count) return Ok();
  return LineError(file,
                   line.number,
                   fmt::format("has {} fields, expected {} ('{}'; names must not contain blanks): "
                               "correct or remove the line",
                               line.fields.size(),
                               count,
                               layout));
}

std::optional<double> ParseNumber(std::string_view field) {
  if (field.starts_with('+')) field.remove_prefix(1);
  double value = 0;
  const auto [end, code] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (code != std::errc() || end != field.data() + field.size()) return std::nullopt;
  return value;
}

Result<std::vector<double>> ParseNumbers(std::string_view text,
                                         const std::filesystem::path& file,
                                         std::size_t count,
                                         std::string_view what) {
  std::vector<double> numbers;
  for (const TextLine& line : SplitLines(text)) {
    for (const std::string_view field : line.fields) {
      const std::optional<double> number = ParseNumber(field);
      if (!number) {
        return LineError(
            file,
            line.number,
            fmt::format(
                "'{}' is not a number; expected {} ({} numbers)", Shown(field), what, count));
      }
      if (numbers.size() == count) {
        return LineError(
            file, line.number, fmt::format("has more than {} numbers; expected {}", count, what));
      }
      numbers.push_back(*number);
    }
  }
  if (numbers.size() < count) {
    return InvalidInput(fmt::format("{}: has {} numbers, expected {} ({}): is the file whole?",
                                    file.string(),
                                    numbers.size(),
                                    count,
                                    what));
  }
  return numbers;
}

}  // namespace deepslam::formats
