// Files in and out: whole files as bytes, written aside and renamed, so that a reader never sees
// half of one. Messages name the file and the reason (no space left, read-only file system,
// permission denied).
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "deepslam/core/result.h"
#include "deepslam/core/text_pieces.h"

namespace deepslam::storage {

// Files larger than this are refused by ReadFile (2 GiB): nothing here is that large.
inline constexpr std::uintmax_t kMaxFileBytes = std::uintmax_t{1} << 31;

// kInvalidInput when the file is missing, no file, too large or unreadable.
[[nodiscard]] Result<std::string> ReadFile(const std::filesystem::path& file);
// The same by pieces of a quarter of a megabyte.
[[nodiscard]] Result<TextSource> OpenText(const std::filesystem::path& file);

// Writes to FILE.tmp-<pid>, syncs, renames, syncs the folder. kFailed on any error; the old file
// then still stands.
// A process that is killed in between leaves FILE.tmp-<pid> (RemoveAsideFiles). A link stays a
// link: what it leads to is replaced. Devices and pipes are written into as they are.
[[nodiscard]] Status WriteFileAtomically(const std::filesystem::path& file, std::string_view bytes);

// Writes and syncs in place: for files of a folder that is itself renamed as a whole.
[[nodiscard]] Status WriteFileSynced(const std::filesystem::path& file, std::string_view bytes);

// Many of them: written first, synced together. Syncing all takes hardly longer than syncing one,
// as the file system writes down what they have in common.
[[nodiscard]] Status WriteFileUnsynced(const std::filesystem::path& file, std::string_view bytes);
[[nodiscard]] Status WriteFileUnsynced(const std::filesystem::path& file, const TextWriter& text);
[[nodiscard]] Status SyncFiles(std::span<const std::filesystem::path> files);
[[nodiscard]] Status SyncFolder(const std::filesystem::path& folder);
// Takes away what killed processes left of WriteFileAtomically in a folder (not in folders in it):
// NAME.json.tmp-<pid>, NAME.html.tmp-<pid>, where no such process runs on this machine; so the
// folder's writers must all be on it. A folder that does not exist holds none.
[[nodiscard]] Status RemoveAsideFiles(const std::filesystem::path& folder);
[[nodiscard]] Status MakeFolders(const std::filesystem::path& folder);

// sha256 of a file's bytes, read piecewise.
[[nodiscard]] Result<std::string> HashFile(const std::filesystem::path& file);
// sha256 over names and contents of all files below a folder, sorted; where it lies and times do
// not enter.
[[nodiscard]] Result<std::string> HashFolder(const std::filesystem::path& folder);

}  // namespace deepslam::storage
