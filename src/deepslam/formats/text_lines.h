// Text files of numbers and names, line by line: what the lists, matrices and tables of the capture
// layouts have in common.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/core/result.h"

namespace deepslam::formats {

struct TextLine {
  int number = 0;                        // 1-based
  std::vector<std::string_view> fields;  // into the text that was split
  bool unfinished = false;               // the text ends in it, without a line feed
};

// The lines that carry something, fields separated by blanks, tabs or commas; empty lines and those
// that begin with '#' are left out, a byte order mark is skipped. `text` must outlive this.
class LineReader {
 public:
  explicit LineReader(std::string_view text);

  // The next one, which lasts until the one after it is asked for; null at the end.
  [[nodiscard]] const TextLine* Next();

 private:
  std::string_view left_;
  char line_end_ = '\n';
  TextLine line_;
};
// All of them, of short texts.
[[nodiscard]] std::vector<TextLine> SplitLines(std::string_view text);

// The beginning of a text without control characters, for messages.
[[nodiscard]] std::string Shown(std::string_view text);

// kInvalidInput `FILE:LINE: FAULT`.
[[nodiscard]] Error LineError(const std::filesystem::path& file, int line, std::string_view fault);

// Whether what is wrong with a line is that whoever wrote it was stopped: the line is the last one
// and unfinished. Said in `warnings`; the line is to be left out.
[[nodiscard]] bool IsLeftOut(const std::filesystem::path& file,
                             const TextLine& line,
                             std::vector<std::string>& warnings);

// What a field that should be a time in seconds is instead: one in a smaller unit, as its size
// tells, or none.
[[nodiscard]] Error TimeError(const std::filesystem::path& file,
                              int line,
                              std::string_view name,
                              std::string_view field);

// Refuses lines that have not `count` fields; `layout` says what they are.
[[nodiscard]] Status CheckFieldCount(const std::filesystem::path& file,
                                     const TextLine& line,
                                     std::size_t count,
                                     std::string_view layout);

// The whole field as a number, "nan" and "inf" included; nothing when it is none.
[[nodiscard]] std::optional<double> ParseNumber(std::string_view field);

// Exactly `count` numbers over all lines of a text (a matrix). `what` names them in messages.
[[nodiscard]] Result<std::vector<double>> ParseNumbers(std::string_view text,
                                                       const std::filesystem::path& file,
                                                       std::size_t count,
                                                       std::string_view what);

}  // namespace deepslam::formats
