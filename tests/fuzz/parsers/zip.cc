// Catalogues are zip archives. libzip itself is not instrumented.
#include <sys/mman.h>
#include <unistd.h>

#include <string>

#include "deepslam/library/catalogue.h"
#include "deepslam/library/zip_archive.h"
#include "fuzz/entry.h"

DEEPSLAM_FUZZ(zip) {
  constexpr std::size_t kMaxBytes = 1 << 16;
  const int handle = ::memfd_create("fuzz.zip", 0);
  DEEPSLAM_CHECK(handle >= 0, "memory files are there");
  DEEPSLAM_CHECK(::write(handle, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size()),
                 "memory files take bytes");
  bool accepted = false;
  {
    const auto archive = library::ZipArchive::Open("/proc/self/fd/" + std::to_string(handle));
    if (archive.ok()) {
      const auto entry = archive->Read("PluginFurnitureCatalog.properties", kMaxBytes);
      if (entry.ok()) {
        accepted = true;
        DEEPSLAM_CHECK(entry->size() <= kMaxBytes, "entries are bounded");
        (void)library::ParseCatalogue(*entry);
      }
    }
  }
  ::close(handle);
  return accepted;
}
