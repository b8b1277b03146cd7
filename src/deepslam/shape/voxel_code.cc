#include "deepslam/shape/voxel_code.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "deepslam/core/check.h"
#include "deepslam/core/sha256.h"

namespace deepslam::shape {
namespace {

constexpr std::size_t kChecksumBytes = 4;  // of SHA-256; one damaged code in 2^32 passes
constexpr int kFlushBytes = 5;             // the cached one and four of `low_`
// No grid takes more: the model never pays much over one bit a voxel.
constexpr std::size_t kMaxCodeBytes = 2 * kGridSize * kGridSize * kGridSize / 8;

// The chance that the next voxel of a pattern is free, learnt as voxels come: fast at first.
class Chance {
 public:
  static constexpr int kBits = 16;  // of a chance as it is coded: the range keeps 8 more (kTop)

  // Of 2^kBits, never all and never nothing.
  [[nodiscard]] std::uint32_t free() const {
    return static_cast<std::uint32_t>(free_ >> (kFineBits - kBits));
  }
  void Learn(bool occupied) {
    constexpr int kSlowest = 250;  // voxels: then a chance moves by 1/250 of its error
    // 12 of 2^16: no voxel costs more than 12.4 bits.
    constexpr int kSure = 12 << (kFineBits - kBits);
    const int target = occupied ? kSure : (1 << kFineBits) - kSure;
    free_ += 2 * (target - free_) / (2 * count_ + 3);
    if (count_ < kSlowest) ++count_;
  }

 private:
  static constexpr int kFineBits = 28;  // the slowest steps still count, and twice one fits an int
  int free_ = 1 << (kFineBits - 1);
  int count_ = 0;
};

// Rows of voxels along k as far as they are coded, bit k for voxel k; free ones lie all around.
class Rows {
 public:
  std::uint64_t& At(int i, int j) { return bits_[Index(i, j)]; }
  [[nodiscard]] std::uint64_t At(int i, int j) const { return bits_[Index(i, j)]; }

 private:
  static constexpr std::size_t kSide = kGridSize + 2;  // with a free row at either end
  static_assert(kGridSize == 64, "a row fits a word");

  static std::size_t Index(int i, int j) {
    return static_cast<std::size_t>(i + 1) * kSide + static_cast<std::size_t>(j + 1);
  }

  std::vector<std::uint64_t> bits_ = std::vector<std::uint64_t>(kSide * kSide, 0);
};

// The nine places before a voxel that say most about it, faces and edges, along a row: of the rows
// (i - 1, j) and (i, j - 1) at k - 1, k and k + 1, of (i - 1, j - 1) and (i - 1, j + 1) at k, and
// (i, j, k - 1).
class Patterns {
 public:
  static constexpr std::size_t kCount = 1 << 9;  // nine voxels, each solid or free

  Patterns(const Rows& rows, int i, int j)
      : back_(rows.At(i - 1, j)),
        below_(rows.At(i, j - 1)),
        back_below_(rows.At(i - 1, j - 1)),
        back_above_(rows.At(i - 1, j + 1)) {
    Move(back_, back_window_);
    Move(below_, below_window_);
  }

  // Of the next voxel; `before`: whether the one before it in the row is occupied.
  std::size_t Next(bool before) {
    Move(back_, back_window_);
    Move(below_, below_window_);
    const std::uint64_t pattern = back_window_ | below_window_ << 3 | (back_below_ & 1) << 6 |
                                  (back_above_ & 1) << 7 | static_cast<std::uint64_t>(before) << 8;
    back_below_ >>= 1;
    back_above_ >>= 1;
    return pattern;
  }

 private:
  static void Move(std::uint64_t& row, std::uint64_t& window) {
    window = window >> 1 | (row & 1) << 2;
    row >>= 1;
  }

  std::uint64_t back_;
  std::uint64_t below_;
  std::uint64_t back_below_;
  std::uint64_t back_above_;
  std::uint64_t back_window_ = 0;
  std::uint64_t below_window_ = 0;
};

using Chances = std::array<Chance, Patterns::kCount>;

constexpr std::uint32_t kTop = 1U << 24;  // below it the range is shifted by a byte

class Encoder {
 public:
  void Encode(bool occupied, std::uint32_t chance_free) {
    const std::uint32_t bound = (range_ >> Chance::kBits) * chance_free;
    if (occupied) {
      low_ += bound;
      range_ -= bound;
    } else {
      range_ = bound;
    }
    while (range_ < kTop) {
      range_ <<= 8;
      ShiftLow();
    }
  }
  std::string Finish() {
    for (int n = 0; n < kFlushBytes; ++n) ShiftLow();
    // The decoder reads zeros behind the end.
    while (!bytes_.empty() && bytes_.back() == '\0') bytes_.pop_back();
    return std::move(bytes_);
  }

 private:
  // The topmost byte of `low_` is settled unless a carry can still run through it.
  void ShiftLow() {
    if (low_ < 0xFF000000U || low_ >> 32 != 0) {
      const auto carry = static_cast<std::uint8_t>(low_ >> 32);
      if (has_cache_) bytes_ += static_cast<char>(static_cast<std::uint8_t>(cache_ + carry));
      for (; num_pending_ > 0; --num_pending_)
        bytes_ += static_cast<char>(static_cast<std::uint8_t>(0xFF + carry));
      cache_ = static_cast<std::uint8_t>(low_ >> 24);
      has_cache_ = true;
    } else {
      ++num_pending_;
    }
    low_ = (low_ & 0x00FFFFFFU) << 8;
  }

  std::uint64_t low_ = 0;
  std::uint32_t range_ = 0xFFFFFFFFU;
  std::uint8_t cache_ = 0;
  bool has_cache_ = false;
  std::size_t num_pending_ = 0;
  std::string bytes_;
};

class Decoder {
 public:
  explicit Decoder(std::string_view bytes) : bytes_(bytes) {
    for (int n = 0; n < 4; ++n) code_ = code_ << 8 | Next();
  }
  bool Decode(std::uint32_t chance_free) {
    const std::uint32_t bound = (range_ >> Chance::kBits) * chance_free;
    const bool occupied = code_ >= bound;
    if (occupied) {
      code_ -= bound;
      range_ -= bound;
    } else {
      range_ = bound;
    }
    while (range_ < kTop) {
      range_ <<= 8;
      code_ = code_ << 8 | Next();
    }
    return occupied;
  }
  [[nodiscard]] bool AtEnd() const { return at_ >= bytes_.size(); }

 private:
  std::uint32_t Next() {
    return at_ < bytes_.size() ? static_cast<std::uint8_t>(bytes_[at_++]) : 0;
  }

  std::string_view bytes_;
  std::size_t at_ = 0;
  std::uint32_t range_ = 0xFFFFFFFFU;
  std::uint32_t code_ = 0;
};

std::uint64_t DecodeRow(Patterns patterns, Chances& chances, Decoder& decoder) {
  std::uint64_t row = 0;
  bool before = false;
  for (int k = 0; k < kGridSize; ++k) {
    Chance& chance = chances[patterns.Next(before)];
    before = decoder.Decode(chance.free());
    row |= static_cast<std::uint64_t>(before) << k;
    chance.Learn(before);
  }
  return row;
}

VoxelGrid DecodeGrid(Decoder& decoder) {
  VoxelGrid grid;
  Rows rows;
  Chances chances;
  for (int i = 0; i < kGridSize; ++i) {
    for (int j = 0; j < kGridSize; ++j) {
      const std::uint64_t row = DecodeRow(Patterns(rows, i, j), chances, decoder);
      rows.At(i, j) = row;
      for (int k = 0; row != 0 && k < kGridSize; ++k)
        grid.occupied[VoxelGrid::Index(i, j, k)] = static_cast<std::uint8_t>(row >> k & 1);
    }
  }
  return grid;
}

std::string Checksum(const VoxelGrid& grid) {
  const std::string hex =
      Sha256Hex({reinterpret_cast<const char*>(grid.occupied.data()), grid.occupied.size()});
  std::string bytes;
  for (std::size_t n = 0; n < kChecksumBytes; ++n)
    bytes += static_cast<char>(std::stoi(hex.substr(2 * n, 2), nullptr, 16));
  return bytes;
}

}  // namespace

std::string EncodeVoxels(const VoxelGrid& grid) {
  DEEPSLAM_CHECK(grid.occupied.size() == VoxelGrid().occupied.size(), "a grid of another size");
  Rows rows;
  Chances chances;
  Encoder encoder;
  for (int i = 0; i < kGridSize; ++i) {
    for (int j = 0; j < kGridSize; ++j) {
      Patterns patterns(rows, i, j);
      bool before = false;
      for (int k = 0; k < kGridSize; ++k) {
        Chance& chance = chances[patterns.Next(before)];
        before = grid.At(i, j, k);
        rows.At(i, j) |= static_cast<std::uint64_t>(before) << k;
        encoder.Encode(before, chance.free());
        chance.Learn(before);
      }
    }
  }
  return Checksum(grid) + encoder.Finish();
}

Result<VoxelGrid> DecodeVoxels(std::string_view bytes) {
  if (bytes.size() < kChecksumBytes || bytes.size() > kMaxCodeBytes) {
    return InvalidInput("voxel code: " + std::to_string(bytes.size()) + " bytes, must be " +
                        std::to_string(kChecksumBytes) + " to " + std::to_string(kMaxCodeBytes));
  }
  Decoder decoder(bytes.substr(kChecksumBytes));
  VoxelGrid grid = DecodeGrid(decoder);
  if (!decoder.AtEnd()) return InvalidInput("voxel code: bytes behind its end");
  if (bytes.substr(0, kChecksumBytes) != Checksum(grid))
    return InvalidInput("voxel code: damaged, its checksum does not fit");
  return grid;
}

}  // namespace deepslam::shape
