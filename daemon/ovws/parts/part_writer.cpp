#include "daemon/ovws/parts/part_writer.hpp"

#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "daemon/ovws/parts/provenance.hpp"
#include "proto/json_text.hpp"

namespace ovws {
namespace {

namespace fs = std::filesystem;

tl::unexpected<Error> cannot_write(const fs::path& path, const std::string& why) {
  return fail(Errc::unavailable, "output", path.string() + " cannot be written: " + why);
}

}  // namespace

PartWriter::PartWriter(fs::path path, fs::path temporary, std::FILE* file)
    : path_(std::move(path)), temporary_(std::move(temporary)), file_(file) {}

PartWriter::~PartWriter() {
  if (!file_) return;
  std::error_code ignored;
  fs::remove(temporary_, ignored);
}

Result<PartWriter> PartWriter::make(const fs::path& folder, const std::string& name,
                                    const PartHead& head) {
  std::error_code failed;
  fs::create_directories(folder, failed);
  if (failed) return cannot_write(folder, failed.message());
  fs::path temporary = folder / fmt::format(".{}.{}.{}.tmp", name, host_name(), ::getpid());
  std::FILE* const file = std::fopen(temporary.c_str(), "we");
  if (file == nullptr) return cannot_write(temporary, std::strerror(errno));
  PartWriter writer(folder / (name + ".jsonl"), std::move(temporary), file);
  const std::string line = json_text(head) + "\n";
  std::fwrite(line.data(), 1, line.size(), file);
  return writer;
}

void PartWriter::add(std::uint64_t item, const std::string& result) {
  const std::string line = fmt::format("{{\"item\":{},\"result\":{}}}\n", item, result);
  std::fwrite(line.data(), 1, line.size(), file_.get());  // finish() reports an error
}

Result<void> PartWriter::finish() {
  const fs::path host = fs::path(path_).replace_extension(".host.json");
  auto written = write_provenance(host_facts(), host);
  errno = 0;
  const bool whole = std::fflush(file_.get()) == 0 && std::ferror(file_.get()) == 0 &&
                     ::fsync(::fileno(file_.get())) == 0;
  if (written && !whole) written = cannot_write(path_, std::strerror(errno));
  std::error_code failed;
  if (written) fs::rename(temporary_, path_, failed);
  if (failed) written = cannot_write(path_, failed.message());
  if (written) file_.reset();
  return written;
}

}  // namespace ovws
