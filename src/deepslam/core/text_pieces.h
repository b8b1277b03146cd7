// Texts that grow with the length of a capture by megabytes a minute and are never there as a
// whole.
#pragma once

#include <concepts>
#include <functional>
#include <string>
#include <string_view>
#include <utility>

#include "deepslam/core/result.h"

namespace deepslam {

// Takes the pieces of a text in their order; an error ends the text.
using TextSink = std::function<Status(std::string_view piece)>;
// Hands a text over to a sink.
using TextWriter = std::function<Status(const TextSink& sink)>;
// All of it, where it is short or somebody wants it whole.
[[nodiscard]] Result<std::string> WholeText(const TextWriter& writer);

// A text to read, once: by pieces as they come, or the whole of one that is there (and outlives
// this).
class TextSource {
 public:
  // Gives the next piece, which lasts until the one after it is asked for; an empty one at the end.
  using NextPiece = std::function<Result<std::string_view>()>;

  explicit TextSource(NextPiece next) : next_(std::move(next)) {}
  template <std::convertible_to<std::string_view> Text>
  TextSource(const Text& text)  // NOLINT(google-explicit-constructor): one piece is as good
      : next_([whole = std::string_view(text)]() mutable -> Result<std::string_view> {
          return std::exchange(whole, {});
        }) {}

  [[nodiscard]] Result<std::string_view> Next() { return next_(); }

 private:
  NextPiece next_;
};

// The text line by line, without the line breaks; behind the last break there is a line only where
// there is something. The first error of the text or of `use` ends it; that of `use` is told with
// the line: "NAME:LINE: ...".
[[nodiscard]] Status ForLines(TextSource text,
                              std::string_view name,
                              const std::function<Status(std::string_view line)>& use);

}  // namespace deepslam
