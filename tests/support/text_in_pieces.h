// Texts as files give them: by pieces, each gone when the next one is asked for.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "deepslam/core/text_pieces.h"

namespace deepslam::testing_support {

inline TextSource InPieces(std::string_view text, std::size_t num_bytes) {
  return TextSource([text = std::string(text),
                     piece = std::string(),
                     at = std::size_t{0},
                     num_bytes]() mutable -> Result<std::string_view> {
    piece.assign(text, at, num_bytes);
    at += piece.size();
    return std::string_view(piece);
  });
}

}  // namespace deepslam::testing_support
