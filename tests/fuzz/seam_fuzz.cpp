// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
// What crosses the seam: a file of messages (first byte 'f'), or one message (any other), which a
// file's checksums would keep from the decoder.
#include "cf/formats/seam_file.h"
#include "formats/seam_examples.h"
#include "fuzz/fuzz_target.h"
#include "support/temp_folder.h"

std::vector<std::string> cf::fuzz::seeds() {
  std::mt19937 random(1);
  const std::vector<SeamMessage> messages = {support::someHello(), support::someStep(2, random),
                                             support::someDone()};
  const support::TempFolder folder;
  SeamWriter writer(folder / "uav.seam");
  std::vector<std::string> made;
  for (const SeamMessage& message : messages) {
    writer.write(message);
    made.push_back("m" + SeamEncoder().encode(message));
  }
  made.push_back("f" + support::fileText(folder / "uav.seam"));
  return made;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  if (data[0] != 'f') {
    const auto message = cf::decodeSeamMessage({reinterpret_cast<const char*>(data) + 1, size - 1});
    if (message)
      cf::fuzz::require(!cf::SeamEncoder().encode(*message).empty(),
                        "what is read can be written again");
    return 0;
  }
  static cf::fuzz::InputFile file("uav.seam");
  const auto& path = file.put(data + 1, size - 1);
  cf::fuzz::expectOneLineAtMost(path, [&] {
    cf::SeamReader reader(path);
    while (!reader.ended() && reader.next()) {
    }
  });
  return 0;
}
