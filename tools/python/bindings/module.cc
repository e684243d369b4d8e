// The module clothid._clothid: the library in Python's spelling. The package clothid beside it adds names and types.
#include <glog/logging.h>
#include <pybind11/pybind11.h>

#include "identify/base/version.h"
#include "tools/python/bindings/bindings.h"

PYBIND11_MODULE(_clothid, module) {
  // Ceres logs through glog: to stderr, and only what is fatal.
  FLAGS_logtostderr = true;
  FLAGS_minloglevel = google::GLOG_FATAL;
  module.doc() = "The library clothid. Use the package clothid.";
  module.attr("__version__") = clothid::Version();
  clothid::BindErrors(&module);
  clothid::BindScene(&module);
  clothid::BindMotion(&module);
  clothid::BindSimulate(&module);
  clothid::BindRollout(&module);
  clothid::BindFit(&module);
  clothid::BindPlan(&module);
  clothid::BindPredict(&module);
  clothid::BindLandscape(&module);
  clothid::BindExport(&module);
  clothid::BindView(&module);
}
