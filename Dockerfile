# amorsim with its window and all kernels compiled:
#
#     docker build -t amorsim .
#     docker run --rm -v "$PWD:/work" amorsim run demo
#     docker run --rm -p 8080:8080 amorsim view demo --no-open --host 0.0.0.0 --port 8080
#
# Grading needs user namespaces for bubblewrap, which most containers do not allow.
# Not yet built by those who wrote it: their machine has no Docker.
FROM python:3.12-slim

COPY . /opt/amorsim
RUN python -m pip install --no-cache-dir -c /opt/amorsim/constraints.txt "/opt/amorsim[ui,plot,drawings,mcap,rosbag]" \
    && useradd --create-home student && mkdir /work && chown student /work
USER student
WORKDIR /work
# Kernels are compiled for the processor that builds the image; on another one they are compiled again at the first run.
RUN amorsim compile
ENTRYPOINT ["amorsim"]
CMD ["--help"]
