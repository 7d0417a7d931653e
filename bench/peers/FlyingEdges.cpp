// VTK's flying edges behind one plain function: a module of its own, loaded only when it is
// measured, because VTK's headers are C++17 and its libraries take long to load.

#include <vtkFlyingEdges3D.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkSMPTools.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstring>
#include <ctime>

namespace {

double processorSeconds()
{
    timespec now{};
    (void)clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

} // namespace

/// @param size        voxels along each axis
/// @param bytesEach   1: uint8, 2: int16, 4: float; x fastest, then y
/// @param result      least processor seconds, least seconds by the clock, triangles, vertices
extern "C" void isofrontFlyingEdges(
    const int* size,
    int bytesEach,
    const void* voxels,
    double isovalue,
    int threads,
    int runs,
    double* result)
{
    using Clock = std::chrono::steady_clock;
    vtkSMPTools::SetBackend("STDThread");
    vtkSMPTools::Initialize(threads);
    vtkNew<vtkImageData> image;
    image->SetDimensions(size);
    image->AllocateScalars(
        bytesEach == 1   ? VTK_UNSIGNED_CHAR
        : bytesEach == 2 ? VTK_SHORT
                         : VTK_FLOAT,
        1);
    std::memcpy(
        image->GetScalarPointer(),
        voxels,
        static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) *
            static_cast<std::size_t>(size[2]) * static_cast<std::size_t>(bytesEach));
    for (int run = 0; run < runs; ++run) {
        vtkNew<vtkFlyingEdges3D> filter;
        filter->SetInputData(image);
        filter->SetValue(0, isovalue);
        filter->SetComputeNormals(1);
        filter->SetComputeGradients(0);
        filter->SetComputeScalars(0);
        const auto wallStart = Clock::now();
        const double start = processorSeconds();
        filter->Update();
        const double processor = processorSeconds() - start;
        const double wall = std::chrono::duration<double>(Clock::now() - wallStart).count();
        result[0] = run == 0 ? processor : std::min(result[0], processor);
        result[1] = run == 0 ? wall : std::min(result[1], wall);
        result[2] = static_cast<double>(filter->GetOutput()->GetNumberOfCells());
        result[3] = static_cast<double>(filter->GetOutput()->GetNumberOfPoints());
    }
}
