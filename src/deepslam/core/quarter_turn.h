// Quarter turns of pictures about their middle: cameras are held upright, on either side, or upside
// down.
#pragma once

#include "deepslam/core/image.h"

namespace deepslam {

// As one sees the picture turn.
enum class QuarterTurn { kNone, kClockwise, kHalf, kAnticlockwise };

// Back to where it was.
[[nodiscard]] constexpr QuarterTurn Inverse(QuarterTurn turn) {
  switch (turn) {
    case QuarterTurn::kClockwise:
      return QuarterTurn::kAnticlockwise;
    case QuarterTurn::kAnticlockwise:
      return QuarterTurn::kClockwise;
    case QuarterTurn::kNone:
    case QuarterTurn::kHalf:
      break;
  }
  return turn;
}

// On its side: width and height change places.
[[nodiscard]] constexpr bool OnItsSide(QuarterTurn turn) {
  return turn == QuarterTurn::kClockwise || turn == QuarterTurn::kAnticlockwise;
}

// Clockwise, the left column becomes the upper row.
template <typename T>
[[nodiscard]] Image<T> Turned(const Image<T>& image, QuarterTurn turn) {
  if (turn == QuarterTurn::kNone) return image;
  const int last_u = image.width() - 1;
  const int last_v = image.height() - 1;
  const bool on_its_side = OnItsSide(turn);
  Image<T> turned(on_its_side ? image.height() : image.width(),
                  on_its_side ? image.width() : image.height());
  for (int v = 0; v <= last_v; ++v) {
    const T* const row = image.row(v);
    for (int u = 0; u <= last_u; ++u) {
      if (turn == QuarterTurn::kClockwise) {
        turned(last_v - v, u) = row[u];
      } else if (turn == QuarterTurn::kAnticlockwise) {
        turned(v, last_u - u) = row[u];
      } else {
        turned(last_u - u, last_v - v) = row[u];
      }
    }
  }
  return turned;
}

}  // namespace deepslam
