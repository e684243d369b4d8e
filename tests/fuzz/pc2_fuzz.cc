// Point caches.
#include "datasets/formats/pc2_file.h"
#include "tests/fuzz/track_round_trip.h"

int clothid::FuzzPc2(const std::uint8_t* data, std::size_t size) {
  CheckRoundTrip(AsText(data, size), &ReadPc2, &Pc2Bytes);
  return 0;
}
