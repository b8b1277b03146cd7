#include "deepslam/usd/usdz.h"

#include <array>
#include <cstdint>
#include <limits>
#include <string_view>
#include <vector>

#include <fmt/format.h>

namespace deepslam::usd {
namespace {

constexpr std::size_t kAlignment = 64;         // of every file's first byte (USDZ specification)
constexpr std::size_t kLocalHeaderBytes = 30;  // without name and extra field (APPNOTE.TXT 4.3.7)
constexpr std::uint32_t kLocalHeader = 0x04034b50;           // "PK" 3 4 (4.3.7)
constexpr std::uint32_t kDirectoryEntry = 0x02014b50;        // "PK" 1 2 (4.3.12)
constexpr std::uint32_t kEndOfDirectory = 0x06054b50;        // "PK" 5 6 (4.3.16)
constexpr std::uint16_t kVersion = 20;                       // 2.0: folders, no compression needed
constexpr std::uint16_t kUtf8Names = 1U << 11;               // of the flags
constexpr std::uint16_t kDate = (0U << 9) | (1U << 5) | 1U;  // 1 January 1980: the same every time
constexpr std::uint16_t kPaddingField =
    0x1986;  // the extra field that other writers of USDZ pad by

std::array<std::uint32_t, 256> CrcTable() {
  std::array<std::uint32_t, 256> table;
  for (std::uint32_t n = 0; n < table.size(); ++n) {
    std::uint32_t c = n;
    for (int bit = 0; bit < 8; ++bit) c = (c & 1U) != 0 ? 0xEDB88320U ^ (c >> 1) : c >> 1;
    table[n] = c;
  }
  return table;
}

std::uint32_t Crc32(std::string_view bytes) {
  static const std::array<std::uint32_t, 256> table = CrcTable();
  std::uint32_t crc = ~0U;
  for (const char c : bytes)
    crc = table[(crc ^ static_cast<unsigned char>(c)) & 0xFFU] ^ (crc >> 8);
  return ~crc;
}

template <typename Number>
void Append(Number value, std::string& zip) {
  for (std::size_t n = 0; n < sizeof(Number); ++n)
    zip += static_cast<char>((value >> (8 * n)) & 0xFFU);
}

struct Entry {
  std::uint32_t crc = 0;
  std::uint32_t size = 0;
  std::uint32_t offset = 0;
};

// What local headers and the directory both say.
void AppendFacts(const Entry& entry, std::size_t name_bytes, std::size_t extra, std::string& zip) {
  Append(kVersion, zip);
  Append(kUtf8Names, zip);
  Append(std::uint16_t{0}, zip);  // stored
  Append(std::uint16_t{0}, zip);  // midnight
  Append(kDate, zip);
  Append(entry.crc, zip);
  Append(entry.size, zip);
  Append(entry.size, zip);
  Append(static_cast<std::uint16_t>(name_bytes), zip);
  Append(static_cast<std::uint16_t>(extra), zip);
}

// So many bytes of an extra field that the file begins aligned; a field takes four at least.
std::size_t PaddingFor(std::size_t offset, std::size_t name_bytes) {
  constexpr std::size_t kFieldHeader = 4;  // its id and its length, two bytes each
  std::size_t padding =
      (kAlignment - (offset + kLocalHeaderBytes + name_bytes) % kAlignment) % kAlignment;
  if (padding != 0 && padding < kFieldHeader) padding += kAlignment;
  return padding;
}

void AppendFile(const PackagedFile& file, const Entry& entry, std::string& zip) {
  const std::size_t padding = PaddingFor(zip.size(), file.name.size());
  Append(kLocalHeader, zip);
  AppendFacts(entry, file.name.size(), padding, zip);
  zip += file.name;
  if (padding != 0) {
    Append(kPaddingField, zip);
    Append(static_cast<std::uint16_t>(padding - 4), zip);
    zip.append(padding - 4, '\0');
  }
  zip += file.bytes;
}

void AppendDirectoryEntry(const PackagedFile& file, const Entry& entry, std::string& zip) {
  Append(kDirectoryEntry, zip);
  Append(kVersion, zip);  // made by
  AppendFacts(entry, file.name.size(), 0, zip);
  Append(std::uint16_t{0}, zip);  // comment
  Append(std::uint16_t{0}, zip);  // disk
  Append(std::uint16_t{0}, zip);  // attributes, of programs and of systems
  Append(std::uint32_t{0}, zip);
  Append(entry.offset, zip);
  zip += file.name;
}

}  // namespace

Result<std::string> WriteUsdz(std::span<const PackagedFile> files) {
  std::string zip;
  std::vector<Entry> entries;
  for (const PackagedFile& file : files) {
    if (zip.size() + file.bytes.size() > std::numeric_limits<std::uint32_t>::max() - (1U << 20)) {
      return InvalidInput(
          fmt::format("{}: a USDZ package holds 4 GB; write export.usd: usda instead", file.name));
    }
    const Entry entry = {Crc32(file.bytes),
                         static_cast<std::uint32_t>(file.bytes.size()),
                         static_cast<std::uint32_t>(zip.size())};
    AppendFile(file, entry, zip);
    entries.push_back(entry);
  }
  const auto directory = static_cast<std::uint32_t>(zip.size());
  for (std::size_t n = 0; n < files.size(); ++n) AppendDirectoryEntry(files[n], entries[n], zip);
  const auto directory_bytes = static_cast<std::uint32_t>(zip.size()) - directory;
  Append(kEndOfDirectory, zip);
  Append(std::uint32_t{0}, zip);  // disks
  Append(static_cast<std::uint16_t>(files.size()), zip);
  Append(static_cast<std::uint16_t>(files.size()), zip);
  Append(directory_bytes, zip);
  Append(directory, zip);
  Append(std::uint16_t{0}, zip);  // comment
  return zip;
}

}  // namespace deepslam::usd
