#include "deepslam/layout/face_rectangles.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <utility>

namespace deepslam::layout {
namespace {

constexpr double kBandShare = 0.6;  // of a column or row across an opening: then wall stands there,
constexpr int kBandCells = 2;       // if so many do beside each other: one may be noise

using Cells = std::vector<std::pair<int, int>>;  // slot, row

// Connected cells that pass the test.
std::vector<Cells> Components(const CellBox& within, const CellTest& test) {
  const int width = within.end_slot - within.first_slot;
  const int height = within.end_row - within.first_row;
  std::vector<Cells> components;
  if (width <= 0 || height <= 0) return components;
  std::vector<std::uint8_t> known(static_cast<std::size_t>(width) *
                                  static_cast<std::size_t>(height));
  const auto take = [&](int slot, int row) {
    if (slot < within.first_slot || slot >= within.end_slot || row < within.first_row ||
        row >= within.end_row)
      return false;
    std::uint8_t& mark = known[static_cast<std::size_t>(slot - within.first_slot) *
                                   static_cast<std::size_t>(height) +
                               static_cast<std::size_t>(row - within.first_row)];
    if (mark != 0) return false;
    mark = 1;
    return test(slot, row);
  };
  for (int slot = within.first_slot; slot < within.end_slot; ++slot) {
    for (int row = within.first_row; row < within.end_row; ++row) {
      if (!take(slot, row)) continue;
      Cells cells = {{slot, row}};
      for (std::size_t n = 0; n < cells.size(); ++n) {
        const auto [s, r] = cells[n];
        for (const auto& [ds, dr] : {std::pair(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
          if (take(s + ds, r + dr)) cells.emplace_back(s + ds, r + dr);
        }
      }
      components.push_back(std::move(cells));
    }
  }
  return components;
}

// First and end of where counts reach half of their largest.
std::pair<int, int> HalfHeight(const std::vector<int>& counts) {
  const int most = counts.empty() ? 0 : *std::max_element(counts.begin(), counts.end());
  int first = 0;
  int end = static_cast<int>(counts.size());
  while (first < end && 2 * counts[static_cast<std::size_t>(first)] < most) ++first;
  while (end > first && 2 * counts[static_cast<std::size_t>(end - 1)] < most) --end;
  return {first, end};
}

// The rectangle that most of the cells fill.
CellBox BoxOf(const Cells& cells, const CellBox& within) {
  std::vector<int> by_slot(static_cast<std::size_t>(within.end_slot - within.first_slot), 0);
  std::vector<int> by_row(static_cast<std::size_t>(within.end_row - within.first_row), 0);
  for (const auto& [slot, row] : cells) {
    ++by_slot[static_cast<std::size_t>(slot - within.first_slot)];
    ++by_row[static_cast<std::size_t>(row - within.first_row)];
  }
  const auto [first_slot, end_slot] = HalfHeight(by_slot);
  const auto [first_row, end_row] = HalfHeight(by_row);
  return {within.first_slot + first_slot,
          within.first_slot + end_slot,
          within.first_row + first_row,
          within.first_row + end_row};
}

// What is left of a box beside columns, then rows, that are wall for the most part.
std::vector<CellBox> WithoutBands(const CellBox& box, const CellTest& wall) {
  std::vector<CellBox> pieces;
  for (const bool columns : {true, false}) {
    const auto [first, end] =
        columns ? std::pair(box.first_slot, box.end_slot) : std::pair(box.first_row, box.end_row);
    const auto part = [&](int from, int to) {
      return columns ? CellBox{from, to, box.first_row, box.end_row}
                     : CellBox{box.first_slot, box.end_slot, from, to};
    };
    int begin = first;
    int num_wall = 0;
    std::vector<CellBox> parts;
    for (int line = first; line <= end; ++line) {
      const bool is_wall = line < end && ShareOf(part(line, line + 1), box, wall) > kBandShare;
      if (is_wall) {
        ++num_wall;
        continue;
      }
      if (num_wall >= kBandCells) {
        if (line - num_wall > begin) parts.push_back(part(begin, line - num_wall));
        begin = line;
      }
      num_wall = 0;
    }
    if (begin == first) continue;
    if (end > begin) parts.push_back(part(begin, end));
    for (const CellBox& rest : parts) {
      const std::vector<CellBox> of_rest = WithoutBands(rest, wall);
      pieces.insert(pieces.end(), of_rest.begin(), of_rest.end());
    }
    return pieces;
  }
  return {box};
}

// Cells that pass, slot by slot, rows running fastest.
class CellGrid {
 public:
  CellGrid(const CellBox& within, const CellTest& test)
      : within_(within),
        width_(std::max(0, within.end_slot - within.first_slot)),
        height_(std::max(0, within.end_row - within.first_row)) {
    for (int slot = 0; slot < width_; ++slot) {
      for (int row = 0; row < height_; ++row)
        passes_.push_back(test(within.first_slot + slot, within.first_row + row) ? 1 : 0);
    }
  }

  // The largest rectangle that passes; empty where none does.
  [[nodiscard]] CellBox Largest() const {
    CellBox largest;
    std::vector<int> length(static_cast<std::size_t>(height_), 0);  // of each row, up to a slot
    for (int slot = 0; slot < width_; ++slot) {
      for (int row = 0; row < height_; ++row) {
        int& of_row = length[static_cast<std::size_t>(row)];
        of_row = Passes(slot, row) ? of_row + 1 : 0;
      }
      for (int first = 0; first < height_; ++first) {
        int least = width_;
        for (int row = first; row < height_; ++row) {
          least = std::min(least, length[static_cast<std::size_t>(row)]);
          if (least == 0) break;
          const CellBox box{within_.first_slot + slot + 1 - least,
                            within_.first_slot + slot + 1,
                            within_.first_row + first,
                            within_.first_row + row + 1};
          if (box.width_m() * box.height_m() > largest.width_m() * largest.height_m())
            largest = box;
        }
      }
    }
    return largest;
  }
  void TakeOut(const CellBox& box) {
    for (int slot = box.first_slot; slot < box.end_slot; ++slot) {
      for (int row = box.first_row; row < box.end_row; ++row)
        passes_[At(slot - within_.first_slot, row - within_.first_row)] = 0;
    }
  }

 private:
  [[nodiscard]] std::size_t At(int slot, int row) const {
    return static_cast<std::size_t>(slot) * static_cast<std::size_t>(height_) +
           static_cast<std::size_t>(row);
  }
  [[nodiscard]] bool Passes(int slot, int row) const { return passes_[At(slot, row)] != 0; }

  CellBox within_;
  int width_;
  int height_;
  std::vector<std::uint8_t> passes_;
};

}  // namespace

double ShareOf(const CellBox& box, const CellBox& within, const CellTest& test) {
  int num = 0;
  int count = 0;
  for (int slot = std::max(box.first_slot, within.first_slot);
       slot < std::min(box.end_slot, within.end_slot);
       ++slot) {
    for (int row = std::max(box.first_row, within.first_row);
         row < std::min(box.end_row, within.end_row);
         ++row) {
      ++count;
      num += test(slot, row) ? 1 : 0;
    }
  }
  return count > 0 ? static_cast<double>(num) / count : 0.0;
}

std::vector<CellBox> RectanglesOf(const CellBox& within,
                                  const CellTest& test,
                                  const CellTest& wall) {
  std::vector<CellBox> boxes;
  for (const Cells& cells : Components(within, test)) {
    CellBox whole{within.end_slot, within.first_slot, within.end_row, within.first_row};
    for (const auto& [slot, row] : cells) {
      whole.first_slot = std::min(whole.first_slot, slot);
      whole.end_slot = std::max(whole.end_slot, slot + 1);
      whole.first_row = std::min(whole.first_row, row);
      whole.end_row = std::max(whole.end_row, row + 1);
    }
    for (const CellBox& piece : WithoutBands(whole, wall)) {
      Cells inside;
      std::ranges::copy_if(cells, std::back_inserter(inside), [&](const auto& cell) {
        return cell.first >= piece.first_slot && cell.first < piece.end_slot &&
               cell.second >= piece.first_row && cell.second < piece.end_row;
      });
      if (!inside.empty()) boxes.push_back(BoxOf(inside, piece));
    }
  }
  return boxes;
}

std::vector<CellBox> FullRectanglesOf(const CellBox& within,
                                      const CellTest& test,
                                      std::size_t most) {
  CellGrid grid(within, test);
  std::vector<CellBox> boxes;
  while (boxes.size() < most) {
    const CellBox largest = grid.Largest();
    if (largest.end_slot <= largest.first_slot) break;
    boxes.push_back(largest);
    grid.TakeOut(largest);
  }
  return boxes;
}

}  // namespace deepslam::layout
