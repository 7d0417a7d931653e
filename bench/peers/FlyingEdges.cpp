#include "FlyingEdges.h"

#include <vtkCellArray.h>
#include <vtkDataArray.h>
#include <vtkFloatArray.h>
#include <vtkFlyingEdges3D.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkSMPTools.h>
#include <vtkVersion.h>

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

extern "C" void isofrontFlyingEdgesTime(
    const int* size,
    int bytesEach,
    const void* voxels,
    double isovalue,
    int threads,
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
    vtkNew<vtkFlyingEdges3D> filter;
    filter->SetInputData(image);
    filter->SetValue(0, isovalue);
    filter->ComputeNormalsOn();
    filter->ComputeGradientsOff();
    filter->ComputeScalarsOff();
    const auto wallStart = Clock::now();
    const double start = processorSeconds();
    filter->Update();
    result[0] = processorSeconds() - start;
    result[1] = std::chrono::duration<double>(Clock::now() - wallStart).count();
    result[2] = static_cast<double>(filter->GetOutput()->GetNumberOfCells());
    result[3] = static_cast<double>(filter->GetOutput()->GetNumberOfPoints());
}

extern "C" void isofrontFlyingEdgesMesh(
    const std::vector<float>& values,
    const std::array<int, 3>& count,
    const std::array<double, 3>& origin,
    double spacing,
    double isovalue,
    isofront::bench::peers::PeerMesh& mesh)
{
    vtkSMPTools::Initialize(1);
    vtkNew<vtkFloatArray> scalars;
    // VTK takes no pointer to const; the filter only reads
    scalars->SetArray(const_cast<float*>(values.data()), static_cast<vtkIdType>(values.size()), 1);
    vtkNew<vtkImageData> image;
    image->SetDimensions(count[0], count[1], count[2]);
    image->SetOrigin(origin[0], origin[1], origin[2]);
    image->SetSpacing(spacing, spacing, spacing);
    image->GetPointData()->SetScalars(scalars);
    vtkNew<vtkFlyingEdges3D> filter;
    filter->SetInputData(image);
    filter->SetValue(0, isovalue);
    filter->ComputeNormalsOn();
    filter->ComputeGradientsOff();
    filter->ComputeScalarsOff();
    filter->Update();

    vtkPolyData* const output = filter->GetOutput();
    const vtkIdType points = output->GetNumberOfPoints();
    vtkDataArray* const normals = output->GetPointData()->GetNormals();
    for (vtkIdType i = 0; i < points; ++i) {
        double at[3];
        output->GetPoint(i, at);
        mesh.positions.insert(mesh.positions.end(), at, at + 3);
        if (normals != nullptr) {
            normals->GetTuple(i, at);
            for (const double value : at)
                mesh.normals.push_back(static_cast<float>(value));
        }
    }
    vtkCellArray* const polygons = output->GetPolys();
    polygons->InitTraversal();
    vtkIdType corners = 0;
    const vtkIdType* ids = nullptr;
    while (polygons->GetNextCell(corners, ids) != 0)
        if (corners == 3)
            for (int k = 0; k < 3; ++k)
                mesh.indices.push_back(static_cast<std::uint32_t>(ids[k]));
}

extern "C" const char* isofrontVtkVersion()
{
    return vtkVersion::GetVTKVersion();
}
