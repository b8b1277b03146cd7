#include "deepslam/core/text_pieces.h"

#include <cstddef>
#include <string>

namespace deepslam {

Result<std::string> WholeText(const TextWriter& writer) {
  std::string text;
  const auto append = [&text](std::string_view piece) {
    text += piece;
    return Ok();
  };
  if (Status status = writer(append); !status.ok()) return status.error();
  return text;
}

Status ForLines(TextSource text,
                std::string_view name,
                const std::function<Status(std::string_view line)>& use) {
  std::string begun;  // a line whose end did not come yet
  std::size_t line_number = 0;
  const auto use_line = [&](std::string_view line) -> Status {
    ++line_number;
    const Status status = use(line);
    if (status.ok()) return status;
    return Error{
        status.error().code,
        std::string(name) + ":" + std::to_string(line_number) + ": " + status.error().message};
  };
  while (true) {
    Result<std::string_view> piece = text.Next();
    if (!piece.ok()) return piece.error();
    if (piece->empty()) return begun.empty() ? Ok() : use_line(begun);
    for (std::size_t end = piece->find('\n'); end != std::string_view::npos;
         end = piece->find('\n')) {
      begun += piece->substr(0, end);
      if (Status status = use_line(begun); !status.ok()) return status;
      begun.clear();
      piece->remove_prefix(end + 1);
    }
    begun += *piece;
  }
}

}  // namespace deepslam
