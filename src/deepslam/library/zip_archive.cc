#include "deepslam/library/zip_archive.h"

#include <cstdint>
#include <utility>

#include <zip.h>

namespace deepslam::library {

struct ZipArchive::Impl {
  zip_t* archive = nullptr;
  std::string file;
  ~Impl() {
    if (archive != nullptr) zip_discard(archive);
  }
};

ZipArchive::ZipArchive(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ZipArchive::~ZipArchive() = default;
ZipArchive::ZipArchive(ZipArchive&&) noexcept = default;
ZipArchive& ZipArchive::operator=(ZipArchive&&) noexcept = default;

Result<ZipArchive> ZipArchive::Open(const std::filesystem::path& file) {
  auto impl = std::make_unique<Impl>();
  impl->file = file.string();
  int code = 0;
  impl->archive = zip_open(file.c_str(), ZIP_RDONLY, &code);
  if (impl->archive == nullptr) {
    zip_error_t error;
    zip_error_init_with_code(&error, code);
    const std::string reason = zip_error_strerror(&error);
    zip_error_fini(&error);
    return InvalidInput(impl->file + ": cannot be read as a zip archive (" + reason + ")");
  }
  return ZipArchive(std::move(impl));
}

Result<std::string> ZipArchive::Read(std::string_view name, std::size_t max_bytes) const {
  const std::string entry(name);
  const std::string place = impl_->file + ": entry '" + entry + "'";
  zip_stat_t stat;
  zip_stat_init(&stat);
  if (zip_stat(impl_->archive, entry.c_str(), 0, &stat) != 0 || (stat.valid & ZIP_STAT_SIZE) == 0) {
    return InvalidInput(place + " is missing");
  }
  if (stat.size > max_bytes) {
    return InvalidInput(place + " is larger than " + std::to_string(max_bytes) + " bytes");
  }
  const std::unique_ptr<zip_file_t, int (*)(zip_file_t*)> file(
      zip_fopen_index(impl_->archive, stat.index, 0), zip_fclose);
  if (!file) return InvalidInput(place + " cannot be opened");
  std::string bytes(static_cast<std::size_t>(stat.size), '\0');
  std::size_t filled = 0;
  while (filled < bytes.size()) {
    const std::int64_t read = zip_fread(file.get(), bytes.data() + filled, bytes.size() - filled);
    if (read <= 0) return InvalidInput(place + " is damaged");
    filled += static_cast<std::size_t>(read);
  }
  return bytes;
}

}  // namespace deepslam::library
