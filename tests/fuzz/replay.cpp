/// A recording with bytes changed, and cut: it is refused, or all of it can be read; nothing else
/// happens.
#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "drivers/record/record_file.hpp"
#include "drivers/replay/recording_reader.hpp"
#include "drivers/replay/replay_camera.hpp"

namespace ovws {
namespace {

constexpr int kFrames = 3;
constexpr std::size_t kPatchBytes = 4;  // three of the place, one of the value

RecordingHeader small_header() {
  RecordingHeader header;
  header.program = "fuzz";
  header.width = header.height = 16;
  return header;
}

std::vector<char> whole_recording() {
  const auto path =
      std::filesystem::temp_directory_path() / ("ovws-fuzz-" + std::to_string(getpid()) + ".h5");
  auto file = RecordFile::create(path.string(), small_header());
  if (!file) std::abort();
  const std::vector<std::byte> pixels(256);
  const std::vector<RecordedSpot> spots(7);
  const std::vector<float> coefficients(5);
  (void)(*file)->add_document("plan", std::string(64, 'a'), "{\"plan_id\": 1}");
  for (int i = 0; i < kFrames; ++i) {
    RecordedFrame frame;
    frame.picture = *(*file)->add_image(pixels, i != 1);
    (*file)->add_frame(frame, spots, coefficients, coefficients);
  }
  if (!(*file)->close({})) std::abort();
  std::ifstream in(path, std::ios::binary);
  std::vector<char> bytes{std::istreambuf_iterator<char>(in), {}};
  std::filesystem::remove(path);
  return bytes;
}

void read_all(const std::string& path) {
  auto reader = RecordingReader::open(path);
  if (!reader) return;
  if ((*reader)->image_bytes() > 1 << 20) return;
  std::vector<std::byte> pixels((*reader)->image_bytes());
  for (const RecordedFrame& frame : (*reader)->frames()) {
    (void)(*reader)->spots(frame);
    (void)(*reader)->coefficients(frame);
    (void)(*reader)->sigma_waves(frame);
    (void)(*reader)->picture(frame, pixels);
  }
  (void)(*reader)->documents();
  reader->reset();
  (void)open_replay_camera(path);
}

}  // namespace
}  // namespace ovws

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::vector<char> whole = ovws::whole_recording();
  std::vector<char> bytes = whole;
  for (std::size_t i = 0; i + ovws::kPatchBytes <= size; i += ovws::kPatchBytes) {
    const std::size_t at = data[i] + 256U * data[i + 1] + 65536U * data[i + 2];
    bytes[at % bytes.size()] = char(data[i + 3]);
  }
  // What is left over cuts the file.
  if (size % ovws::kPatchBytes == 1) bytes.resize(bytes.size() * data[size - 1] / 256);
  const int fd = memfd_create("recording", 0);
  if (write(fd, bytes.data(), bytes.size()) != ssize_t(bytes.size())) std::abort();
  ovws::read_all("/proc/self/fd/" + std::to_string(fd));
  close(fd);
  return 0;
}
