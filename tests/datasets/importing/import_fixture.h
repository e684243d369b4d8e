// A made-up capture as tracks, and how it is imported.
#ifndef CLOTHID_TESTS_DATASETS_IMPORTING_IMPORT_FIXTURE_H_
#define CLOTHID_TESTS_DATASETS_IMPORTING_IMPORT_FIXTURE_H_

#include <gtest/gtest.h>

#include "datasets/importing/import_motion.h"
#include "tests/datasets/importing/made_up_capture.h"
#include "tests/temporary_folder.h"

namespace clothid {

class ImportFixture : public testing::Test {
 protected:
  ImportFixture() : capture_(MadeUpCapture()) {
    tracks_ = ToTracks(capture_, "capture.csv");
    options_.scene_path = folder_.Write("scene.json", R"({"clothid_scene": 1, "handles": [0, 7]})");
    options_.mesh = capture_.mesh;
    options_.handle_nodes = {0, 7};
  }

  TemporaryFolder folder_;
  MotionTensors capture_;
  PointTracks tracks_;
  ImportOptions options_;
};

}  // namespace clothid

#endif  // CLOTHID_TESTS_DATASETS_IMPORTING_IMPORT_FIXTURE_H_
