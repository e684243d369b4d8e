// bands.npz, the bands of a prediction for NumPy.
//
//   times [T] s; quantiles [5]; positions [5, T, N, 3] m, of every node and time; spread [T] and moved [T] m, see
//   `Prediction`; share_parameters, share_finer, share_rest [T], and share_NAME [T] of every parameter
//   that was drawn, see `SpreadShares`.
#ifndef CLOTHID_IDENTIFY_PREDICTION_BANDS_FILE_H_
#define CLOTHID_IDENTIFY_PREDICTION_BANDS_FILE_H_

#include <string>
#include <utility>
#include <vector>

#include "identify/prediction/prediction.h"

namespace clothid {

// The bytes of an uncompressed ZIP archive of files of these names and contents, in which nothing depends on the clock.
// Throws `Error` (kUsage) for more than the 4 GB that such an archive holds.
std::string ArchiveBytes(const std::vector<std::pair<std::string, std::string>>& files);

std::string BandsNpz(const Prediction& prediction, const Posterior& posterior);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_PREDICTION_BANDS_FILE_H_
