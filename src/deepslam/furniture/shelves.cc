// Shelves, bookcases and wall units: columns of compartments side by side, of which some are
// closed.
#include <algorithm>
#include <array>
#include <vector>

#include "deepslam/furniture/draw.h"
#include "deepslam/furniture/kinds.h"

namespace deepslam::furniture {
namespace {

// What all columns of one shelf share.
struct Style {
  double depth = 0;
  double board = 0;  // thickness
  double foot = 0;
  double closed = 0;  // how likely a compartment is a drawer or has doors
  double filled = 0;  // ... is full of books
  bool posts = false;
  bool back = false;
};

struct Column {
  double middle_y = 0;
  double width = 0;
  double height = 0;
};

Style DrawStyle(Random& random) {
  Style style;
  style.depth = random.Uniform(0.2, 0.5);
  style.board = random.Uniform(0.014, 0.04);
  style.foot = Chance(random, 0.5) ? random.Uniform(0.03, 0.12) : 0.0;
  style.closed = Chance(random, 0.4) ? random.Uniform(0.1, 0.5) : 0.0;
  style.filled = Chance(random, 0.35) ? random.Uniform(0.1, 0.7) : 0.0;
  style.posts = style.closed == 0 && Chance(random, 0.4);
  style.back = Chance(random, 0.55);
  return style;
}

// Middles of the boards, from below; evenly spaced, or not.
std::vector<double> Levels(Random& random, const Style& style, double height) {
  const int count = std::max(2, static_cast<int>(height / random.Uniform(0.24, 0.5)) + 1);
  const double uneven = Chance(random, 0.4) ? random.Uniform(0.1, 0.35) : 0.0;
  const double low = style.foot + 0.5 * style.board;
  const double pitch = (height - style.foot - style.board) / (count - 1);
  std::vector<double> levels;
  for (int n = 0; n < count; ++n) {
    const bool end = n == 0 || n == count - 1;
    levels.push_back(low + pitch * (n + (end ? 0.0 : uneven * random.Uniform(-1.0, 1.0))));
  }
  return levels;
}

void Uprights(Random& random, const Style& style, const Column& column, Solids& solids) {
  if (style.posts) {
    const double thickness = random.Uniform(0.02, 0.045);
    for (const double x : kSides)
      for (const double y : kSides)
        solids.Box(Material::kFrame,
                   {x * 0.5 * (style.depth - thickness),
                    column.middle_y + y * 0.5 * (column.width - thickness),
                    0.5 * column.height},
                   {thickness, thickness, column.height});
    return;
  }
  const int count = 2 + (column.width > 0.9 ? Count(random, 0, 2) : 0);
  for (int n = 0; n < count; ++n) {
    const double at = static_cast<double>(n) / (count - 1) - 0.5;
    solids.Box(Material::kBody,
               {0, column.middle_y + (column.width - style.board) * at, 0.5 * column.height},
               {style.depth, style.board, column.height});
  }
}

// Single things, or a row of books from side to side.
void Things(Random& random,
            const Style& style,
            const Column& column,
            double low,
            double high,
            Solids& solids) {
  const bool row = Chance(random, 0.5);
  const int count = row ? 1 : Count(random, 1, 3);
  for (int n = 0; n < count; ++n) {
    const double tall = (high - low) * random.Uniform(0.4, 0.95);
    const double wide =
        column.width * (row ? random.Uniform(0.6, 0.95) : random.Uniform(0.1, 0.35));
    const double free = std::max(0.0, column.width - wide - 2 * style.board);
    solids.Box(Material::kDetail,
               {-0.05 * style.depth,
                column.middle_y + random.Uniform(-0.5, 0.5) * free,
                low + 0.5 * tall - 0.003},
               {style.depth * random.Uniform(0.5, 0.8), wide, tall});
  }
}

void BuildColumn(Random& random, const Style& style, const Column& column, Solids& solids) {
  const std::vector<double> levels = Levels(random, style, column.height);
  for (const double z : levels)
    solids.Box(Material::kTop, {0, column.middle_y, z}, {style.depth, column.width, style.board});
  Uprights(random, style, column, solids);
  if (style.back)
    solids.Box(Material::kBody,
               {-0.5 * style.depth + 0.006, column.middle_y, 0.5 * (style.foot + column.height)},
               {0.012, column.width - 0.004, column.height - style.foot});
  const bool below_first = Chance(random, 0.6);  // what is closed is mostly below
  for (std::size_t n = 0; n + 1 < levels.size(); ++n) {
    const double low = levels[n] + 0.5 * style.board;
    const double high = levels[n + 1] - 0.5 * style.board;
    const bool lower_half = 2 * n + 1 < levels.size();
    const double closed = style.closed * (below_first ? (lower_half ? 1.6 : 0.3) : 1.0);
    if (Chance(random, closed)) {
      solids.Box(Material::kBody,
                 {0.004, column.middle_y, 0.5 * (low + high)},
                 {style.depth, column.width - style.board, high - low + 0.01});
    } else if (Chance(random, style.filled)) {
      Things(random, style, column, low, high, solids);
    }
  }
}

}  // namespace

void BuildShelf(Random& random, Solids& solids) {
  const Style style = DrawStyle(random);
  const int columns = Chance(random, 0.7) ? 1 : Count(random, 2, 3);
  const double height = Chance(random, 0.3) ? random.Uniform(0.5, 1.0) : random.Uniform(1.0, 2.25);
  const double width =
      columns > 1 ? random.Uniform(0.35, 0.95)
                  : (Chance(random, 0.35) ? random.Uniform(0.3, 0.6) : random.Uniform(0.6, 1.8));
  const bool equal = Chance(random, 0.5);
  const double middle_width = columns == 3 ? width * random.Uniform(0.7, 1.3) : width;
  const double total = (columns - 1) * width + middle_width;
  double from = -0.5 * total;
  for (int n = 0; n < columns; ++n) {
    const double wide = n == 1 && columns == 3 ? middle_width : width;
    const double tall = equal ? height : std::max(0.45, height * random.Uniform(0.35, 1.0));
    // Neighbours overlap by a hair, so that the shelf is one piece.
    BuildColumn(random, style, {from + 0.5 * wide, wide + 0.004, tall}, solids);
    from += wide;
  }
}

}  // namespace deepslam::furniture
