#include "deepslam/shape/voxel_code.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

#include "deepslam/core/check.h"
#include "deepslam/core/sha256.h"

namespace deepslam::shape {
namespace {

constexpr std::size_t kChecksumBytes = 4;
constexpr int kFlushBytes = 5;
// No grid takes more: the model never pays much over one bit a voxel.
constexpr std::size_t kMaxBytes = 2 * kGridSize * kGridSize * kGridSize / 8;

// Places before a voxel in the order of coding that say most about it: faces, then edges.
constexpr std::array<std::array<int, 3>, 9> kContext = {{{-1, 0, 0},
                                                         {0, -1, 0},
                                                         {0, 0, -1},
                                                         {-1, -1, 0},
                                                         {-1, 0, -1},
                                                         {0, -1, -1},
                                                         {-1, 1, 0},
                                                         {-1, 0, 1},
                                                         {0, -1, 1}}};

// The chance that the next voxel of a pattern is free, learnt as voxels come: fast at first.
class Chance {
 public:
  static constexpr int kBits = 16;

  // Of 2^kBits, never all and never nothing.
  [[nodiscard]] std::uint32_t free() const {
    return static_cast<std::uint32_t>(free_ >> (kFineBits - kBits));
  }
  void Learn(bool occupied) {
    constexpr int kSlowest = 250;
    constexpr int kSure = 12 << (kFineBits - kBits);
    const int target = occupied ? kSure : (1 << kFineBits) - kSure;
    free_ += 2 * (target - free_) / (2 * count_ + 3);
    if (count_ < kSlowest) ++count_;
  }

 private:
  static constexpr int kFineBits = 28;
  int free_ = 1 << (kFineBits - 1);
  int count_ = 0;
};

class Model {
 public:
  explicit Model(const VoxelGrid& grid) : grid_(grid) {}

  Chance& At(int i, int j, int k) {
    std::size_t pattern = 0;
    for (const auto& step : kContext) {
      const int x = i + step[0];
      const int y = j + step[1];
      const int z = k + step[2];
      const bool occupied = VoxelGrid::Contains(x, y, z) && grid_.At(x, y, z);
      pattern = 2 * pattern + (occupied ? 1 : 0);
    }
    return chances_[pattern];
  }

 private:
  const VoxelGrid& grid_;  // as far as it is coded
  std::array<Chance, std::size_t{1} << kContext.size()> chances_;
};

constexpr std::uint32_t kTop = 1U << 24;

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
  std::uint32_t Next() { return at_ < bytes_.size() ? static_cast<std::uint8_t>(bytes_[at_++]) : 0; }

  std::string_view bytes_;
  std::size_t at_ = 0;
  std::uint32_t range_ = 0xFFFFFFFFU;
  std::uint32_t code_ = 0;
};

std::string Checksum(const VoxelGrid& grid) {
  const std::string hex = Sha256Hex(
      {reinterpret_cast<const char*>(grid.occupied.data()), grid.occupied.size()});
  std::string bytes;
  for (std::size_t n = 0; n < kChecksumBytes; ++n)
    bytes += static_cast<char>(std::stoi(hex.substr(2 * n, 2), nullptr, 16));
  return bytes;
}

}  // namespace

std::string EncodeVoxels(const VoxelGrid& grid) {
  DEEPSLAM_CHECK(grid.occupied.size() == VoxelGrid().occupied.size(), "a grid of another size");
  Model model(grid);
  Encoder encoder;
  for (int i = 0; i < kGridSize; ++i) {
    for (int j = 0; j < kGridSize; ++j) {
      for (int k = 0; k < kGridSize; ++k) {
        const bool occupied = grid.At(i, j, k);
        Chance& chance = model.At(i, j, k);
        encoder.Encode(occupied, chance.free());
        chance.Learn(occupied);
      }
    }
  }
  return Checksum(grid) + encoder.Finish();
}

Result<VoxelGrid> DecodeVoxels(std::string_view bytes) {
  if (bytes.size() < kChecksumBytes || bytes.size() > kMaxBytes) {
    return InvalidInput("voxel code: " + std::to_string(bytes.size()) + " bytes, must be " +
                        std::to_string(kChecksumBytes) + " to " + std::to_string(kMaxBytes));
  }
  VoxelGrid grid;
  Model model(grid);
  Decoder decoder(bytes.substr(kChecksumBytes));
  for (int i = 0; i < kGridSize; ++i) {
    for (int j = 0; j < kGridSize; ++j) {
      for (int k = 0; k < kGridSize; ++k) {
        Chance& chance = model.At(i, j, k);
        const bool occupied = decoder.Decode(chance.free());
        grid.occupied[VoxelGrid::Index(i, j, k)] = occupied ? 1 : 0;
        chance.Learn(occupied);
      }
    }
  }
  if (!decoder.AtEnd()) return InvalidInput("voxel code: bytes behind its end");
  if (bytes.substr(0, kChecksumBytes) != Checksum(grid))
    return InvalidInput("voxel code: damaged, its checksum does not fit");
  return grid;
}

}  // namespace deepslam::shape
