// Point tracks as NumPy arrays: NAME.npy with the positions [T, P, 3]; where they are there, NAME.times.npy with the
// times [T] in s and NAME.faces.npy with triangles [F, 3] of integers, indices of points, beside it. Internal to
// datasets/.
#ifndef CLOTHID_DATASETS_FORMATS_NPY_TRACKS_H_
#define CLOTHID_DATASETS_FORMATS_NPY_TRACKS_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "datasets/formats/point_tracks.h"

namespace clothid {

// The names of the three.
std::vector<std::string> NpyPaths(const std::string& path);

// Reads NAME.npy and the two files beside it. NaN: not seen. Throws `Error`, naming the file: kIo where one cannot be
// read, kBadData where an array is of another shape or type.
PointTracks ReadNpyTracks(const std::string& path);

// The times of an array of shape (T): finite, increasing, at least one. Throws `Error` as above.
Eigen::VectorXd ReadNpyTimes(const std::string& path);

// Writes NAME.npy and, where `tracks` has times and faces, the files beside it; where it has none, those that stand
// there are removed: they would be read as its own. All or none (datasets/files/file_group.h). Labels are not kept.
// Throws `Error` (kIo).
void WriteNpyTracks(const PointTracks& tracks, const std::string& path);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_FORMATS_NPY_TRACKS_H_
