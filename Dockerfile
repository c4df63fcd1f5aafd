# tilth with MPI and PETSc: the commands of the README's section on several processes.
#
#   docker build -t tilth .
#   docker run --rm -v "$PWD:/work" tilth mpiexec -n 4 tilth run case.toml
#
# The core is compiled for the processor of the machine that builds. For an image that others run, too:
#   docker build --build-arg CMAKE_ARGS=-DTILTH_NATIVE=OFF -t tilth .
FROM debian:12

RUN apt-get update && apt-get install -y --no-install-recommends python3-venv python3-dev g++ git python3-petsc4py libpetsc-real-dev python3-mpi4py openmpi-bin libopenblas0-pthread

WORKDIR /opt/tilth
COPY . .
ARG CMAKE_ARGS=""
RUN /usr/bin/python3 -m venv --system-site-packages .venv-mpi && .venv-mpi/bin/pip install . "numpy<2"

# The user of a container is the superuser, and its processes may not read each other's memory.
ENV OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_btl_vader_single_copy_mechanism=none
ENV PATH=/opt/tilth/.venv-mpi/bin:$PATH
WORKDIR /work
