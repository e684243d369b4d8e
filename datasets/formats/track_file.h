// Point tracks in the formats of other programs. What each of them is and holds: the header of its own room, and
// datasets/formats/README.md.
#ifndef CLOTHID_DATASETS_FORMATS_TRACK_FILE_H_
#define CLOTHID_DATASETS_FORMATS_TRACK_FILE_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "datasets/formats/point_tracks.h"

namespace clothid {

enum class TrackFormat {
  kNpy,          // NAME.npy, with NAME.times.npy and NAME.faces.npy
  kTidyCsv,      // NAME.csv with the columns t, id, x, y, z
  kRosCsv,       // NAME.csv with the columns %time, ..: rows of ROS messages; read only
  kTrc,          // NAME.trc
  kObjSequence,  // NAME_####.obj, or a folder of .obj files, or one file
  kPlySequence,  // the same with .ply
  kPc2,          // NAME.pc2
  kVtp,          // NAME.pvd with NAME_0000.vtp, ..; written only
};

// The format by name: the extension, in any letter case; of a folder, what the files in it end in; of a .csv file that
// exists, its first line. Throws `Error`: kUsage naming the formats that are known, kIo where a folder or .csv file
// cannot be read.
TrackFormat FormatOf(const std::string& path);

// The format that `WriteTracks` gives a file of this name. Throws `Error` (kUsage) naming the formats that are known.
TrackFormat OutputFormatOf(const std::string& path);

// Whether files of a format hold triangles beside the positions.
bool HoldsFaces(TrackFormat format);

// The files that tracks called `path` stand in, as far as they are there: those of a sequence, those beside a .npy;
// `path` itself where there is none. Throws `Error` as FormatOf does for a folder.
std::vector<std::string> TrackPaths(const std::string& path);

// Reads tracks of any format but kVtp. The result is in itself consistent: sizes agree, times are finite and increase,
// positions are finite or NaN, faces made of its points. Throws `Error`, naming the file: kUsage as above, kIo where it
// cannot be read, kBadData for what is in it. Polygons of a sequence are cut into the triangles `like` [3 x F], where
// these have their vertices: of a surface that deforms.
PointTracks ReadTracks(const std::string& path, const Eigen::Matrix3Xi* like = nullptr);

// Writes tracks in the format of the extension, whatever stands there, with every digit but for PC2, which keeps
// float32: all files or none. What a format has no place for is left out: times by OBJ, PLY and PC2, names of points by
// all but CSV and TRC, faces by CSV, TRC and PC2. Throws `Error`: kUsage where the format cannot hold the positions (a
// point that is not seen in OBJ, named by frame and point), or lacks what it needs (times in CSV and TRC), kBadData
// where `tracks` is not consistent, kIo.
void WriteTracks(const PointTracks& tracks, const std::string& path);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_FORMATS_TRACK_FILE_H_
